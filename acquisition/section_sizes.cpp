// SPDX-License-Identifier: Apache-2.0
#include "acquisition/section_sizes.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"
#include "fitting/chord.hpp"
#include "fitting/edge_fit.hpp"
#include "fitting/radius_uncertainty.hpp"
#include "fitting/thickness.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using fitting::ContourPoint;
using fitting::Zone;

constexpr const char* radius_method = "orthogonal-distance circle through the edge's points";
constexpr const char* mean_circle_method =
    "mean circle: orthogonal-distance circle through the middle 70 % of the edge's points, which support no form";
static_assert(fitting::mean_circle_share == 0.7);
constexpr const char* chord_method = "NOSETAIL: between the points where the camber line leaves the section";
constexpr const char* thickness_method = "MAX_INSCRIBED: diameter of the largest inscribed circle";

std::string radius_method_of(fitting::EdgeModel model) {
    using fitting::EdgeModel;
    const char* name = model == EdgeModel::ellipse      ? "ellipse"
                       : model == EdgeModel::parabola   ? "parabola"
                       : model == EdgeModel::double_arc ? "double arc"
                                                        : nullptr;
    if (name == nullptr) return radius_method;
    return std::string("radius of curvature at the nose of the orthogonal-distance ") + name;
}

/// The numbers of the edge's model, as far as they say more than the radius.
std::string model_note(const fitting::EdgeFit& edge) {
    std::string note;
    if (edge.parameters.size() < 2) return note;
    for (const auto& parameter : edge.parameters) {
        const auto unit = parameter.name.rfind('_');
        std::string words(parameter.name.substr(0, unit));
        std::replace(words.begin(), words.end(), '_', ' ');
        const bool angle = parameter.name.substr(unit) == "_rad";
        note += "; " + words + " " +
                (angle ? core::fixed(core::deg_from_rad(parameter.value), 2) + " deg"
                       : core::fixed(parameter.value, 4) + " mm");
    }
    return note;
}

Characteristic edge_radius(const char* name, const fitting::SectionFit& fit, Zone zone,
                           std::optional<fitting::EdgeModel> asked) {
    const fitting::EdgeFit& edge = zone == Zone::le ? fit.le : fit.te;
    if (!edge.valid)
        return not_evaluable(name, radius_method_of(edge.model), {}, edge.why.empty() ? "no circular edge" : edge.why);
    const std::string method =
        edge.model == fitting::EdgeModel::free ? mean_circle_method : radius_method_of(edge.model);
    if (asked && edge.model != *asked)
        return not_evaluable(name, method, {},
                             "the points do not tell the form that was asked for; they give " +
                                 core::fixed(edge.radius_mm, 4) + " mm by another");
    const auto uncertainty = fitting::radius_uncertainty(fit, zone);
    auto c = reported(name, method, edge.radius_mm, uncertainty.u95,
                      "arc of " + core::fixed(core::deg_from_rad(edge.arc_angle_rad), 0) + " deg, rms " +
                          core::length_text(edge.rms_mm) + model_note(edge));
    take_uncertainty(uncertainty, fit.contour_noise, c);
    return c;
}

/// Of a point's u95 what is added: the errors of the offset of both have one sign, and bounds have none.
double added_mm(const ContourPoint& p) {
    return p.offset_error_mm + p.bound_mm;
}

/// The uncertainties of a size between two surfaces: noise in quadrature, the rest added.
double size_u95(const ContourPoint& a, const ContourPoint& b) {
    return std::hypot(a.u95_mm - added_mm(a), b.u95_mm - added_mm(b)) + added_mm(a) + added_mm(b);
}

/// Of such a size: what the machine does at both places, as if it did the same at both.
void add_machine(const fitting::SectionFit& fit, const ContourPoint& a, const ContourPoint& b, Characteristic& c) {
    if (!fit.contour_noise.has_fields()) return;
    fitting::ErrorBudget budget;
    const double added = added_mm(a) + added_mm(b);
    budget.bound = added + std::abs(a.machine.known_mm) + std::abs(b.machine.known_mm);
    budget.noise = (*c.u95 - added) / fit.contour_noise.coverage();
    for (std::size_t k = 0; k < fitting::error_sources; ++k)
        budget.machine[k] = a.machine.standard_mm[k] + b.machine.standard_mm[k];
    c.u95 = fit.contour_noise.coverage() * std::hypot(budget.noise, budget.shared()) + budget.bound;
    c.budget = budget;
}

/// The chord and the thickness without a camber line: as the edges and the contour's points say, with bounds of their
/// uncertainties.
Characteristic plain_chord(const fitting::SectionFit& fit, const std::string& why) {
    const auto& le = nearest_to(fit.contour, fit.le_point_mm);
    const auto& te = nearest_to(fit.contour, fit.te_point_mm);
    auto c = reported("chord", "NOSETAIL: between the points where the edges halve the turn of the sides", fit.chord_mm,
                      size_u95(le, te), offset_error_note(le.offset_error_mm + te.offset_error_mm, Unit::mm));
    c.note += (c.note.empty() ? "" : "; ") + why;
    add_machine(fit, le, te, c);
    if (!le.measured || !te.measured) refuse_in_gap(le.measured || te.measured ? 0.5 : 1.0, c);
    return c;
}

Characteristic plain_thickness(const fitting::SectionFit& fit, const std::string& why) {
    const auto& worst = *std::max_element(fit.contour.begin(), fit.contour.end(), [](const auto& a, const auto& b) {
        const auto of_side = [](const ContourPoint& p) {
            return p.zone == Zone::suction || p.zone == Zone::pressure ? p.u95_mm : -1.0;
        };
        return of_side(a) < of_side(b);
    });
    auto c = reported("max_thickness", thickness_method, fitting::largest_inscribed_diameter(fit.contour),
                      size_u95(worst, worst), offset_error_note(2.0 * worst.offset_error_mm, Unit::mm));
    c.note += (c.note.empty() ? "" : "; ") + why;
    add_machine(fit, worst, worst, c);
    const auto unmeasured =
        std::count_if(fit.contour.begin(), fit.contour.end(), [](const auto& p) { return !p.measured; });
    if (unmeasured > 0) refuse_in_gap(static_cast<double>(unmeasured) / static_cast<double>(fit.contour.size()), c);
    return c;
}

Characteristic size_of(const char* name, const fitting::Measure& measure, const fitting::MeasuredSection& measured) {
    const auto uncertainty = measured.uncertainty(measure);
    auto c = reported(name, std::string(measure.method), measure.value, uncertainty.u95,
                      offset_error_note(uncertainty.offset_error, Unit::mm));
    take_uncertainty(uncertainty, measured.fit().contour_noise, c);
    return c;
}

}  // namespace

void add_sizes(SectionResult& section, fitting::MeasuredSection& measured, const EvaluationOptions& options) {
    const auto& fit = *section.fit;
    auto& out = section.characteristics;
    out.push_back(edge_radius("le_radius", fit, Zone::le, options.le_model));
    out.push_back(edge_radius("te_radius", fit, Zone::te, options.te_model));
    const auto chord = fitting::measure_chord(measured, fitting::ChordMethod::nose_tail);
    out.push_back(chord ? size_of("chord", *chord, measured) : plain_chord(fit, chord.error().message));
    const auto thickness = fitting::measure_max_thickness(measured);
    out.push_back(thickness ? size_of("max_thickness", *thickness, measured)
                            : plain_thickness(fit, thickness.error().message));
}

void add_sizes_not_evaluable(SectionResult& section) {
    for (const auto& [name, method] : {std::pair{"le_radius", radius_method},
                                       {"te_radius", radius_method},
                                       {"chord", chord_method},
                                       {"max_thickness", thickness_method}})
        section.characteristics.push_back(not_evaluable(name, method, {}, section.why));
}

}  // namespace cmm::acquisition
