// SPDX-License-Identifier: Apache-2.0
#include "acquisition/evaluation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "fitting/statistics.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using fitting::ContourPoint;
using fitting::Zone;

constexpr double guard_share = 1.65 / 2.0;  // ISO 14253-1:2017: 95 % one-sided of a normal distribution over k = 2

struct ProfileZone {
    Zone zone;
    const char* name;
    bool edge;
};
constexpr std::array profile_zones{
    ProfileZone{Zone::le, "profile_le", true}, ProfileZone{Zone::suction, "profile_suction", false},
    ProfileZone{Zone::te, "profile_te", true}, ProfileZone{Zone::pressure, "profile_pressure", false}};

constexpr double shown_share = 0.0005;  // of a zone that is not evaluable: below 0.1 % nothing is said
constexpr const char* not_reached = "not evaluable there: the ball does not reach";
constexpr const char* profile_method = "line profile ISO 1101, 2 max|d|, nominal frame";
constexpr const char* radius_method = "orthogonal-distance circle through the edge's points";
constexpr const char* chord_method = "NOSETAIL: distance of the nose points";
constexpr const char* thickness_method = "INSCRIBED: diameter of the largest inscribed circle";

Characteristic not_evaluable(const char* name, const std::string& method, std::optional<double> limit,
                             std::string why) {
    return {name, method, {}, {}, limit, Decision::not_evaluable, std::move(why)};
}

Characteristic reported(const char* name, const std::string& method, double value, double u95, std::string note) {
    return {name, method, value, u95, {}, Decision::reported, std::move(note)};
}

std::string systematic_note(double error_mm) {
    return error_mm > 0.0 ? "U95 includes " + core::length_text(error_mm) + " of 2-D offset error" : std::string();
}

std::optional<double> limit_of(const ProfileZone& zone, const EvaluationOptions& options) {
    return zone.edge ? options.edge_profile_mm : options.profile_mm;
}

/// Of a deviation that is the largest of a zone: found among as many places as there are independent values of the
/// noise, about one for three points, in each of four zones. The offset error is there for certain, so the guard band
/// has to hold all of it.
double u95_of_worst(const ContourPoint& worst, const SectionResult& section) {
    constexpr double points_of_a_value = 12.0;
    const auto used = static_cast<double>(section.points.size() - section.rejected());
    const double k = std::max(2.0, fitting::coverage_95_of_largest(std::max(1.0, used / points_of_a_value)));
    return 0.5 * k * (worst.u95_mm - worst.offset_error_mm) + worst.offset_error_mm / guard_share;
}

std::string profile_method_of(const fitting::FilterSpec& filter) {
    static constexpr std::array<std::pair<fitting::FilterKind, const char*>, 3> names{
        {{fitting::FilterKind::gaussian, "Gaussian filter ISO 16610-21"},
         {fitting::FilterKind::spline, "spline filter ISO 16610-22"},
         {fitting::FilterKind::robust_gaussian, "robust Gaussian filter ISO 16610-31"}}};
    for (const auto& [kind, name] : names)
        if (kind == filter.kind)
            return profile_method + std::string(", ") + name + ", cut-off " + core::fixed(filter.cutoff_mm, 3) + " mm";
    return profile_method;
}

std::string worst_note(double deviation_mm, const Vector2d& at) {
    return "worst d " + std::string(deviation_mm > 0 ? "+" : "") + core::length_text(deviation_mm) + " at x " +
           core::fixed(at.x(), 3) + " mm, y " + core::fixed(at.y(), 3) + " mm";
}

/// `deviation` is filtered, a value for each contour point. A filter takes noise away; the uncertainty stays that of
/// the contour.
Characteristic profile(const ProfileZone& zone, const SectionResult& section, const fitting::FilteredZones& deviation,
                       const EvaluationOptions& options) {
    const auto limit = limit_of(zone, options);
    const std::string method = profile_method_of(options.filters.at(zone.zone));
    const auto& contour = section.fit->contour;
    std::optional<std::size_t> worst;
    std::size_t points = 0;
    std::size_t judged = 0;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        if (contour[i].zone != zone.zone) continue;
        ++points;
        if (!deviation.values[i]) continue;
        ++judged;
        if (!worst || std::abs(*deviation.values[i]) > std::abs(*deviation.values[*worst])) worst = i;
    }
    if (points == 0) return not_evaluable(zone.name, method, limit, "the contour has no such zone");
    if (const auto& why = deviation.refused[static_cast<std::size_t>(zone.zone)]; !why.empty())
        return not_evaluable(zone.name, method, limit, why);
    if (!worst) return not_evaluable(zone.name, method, limit, not_reached);
    const double largest = *deviation.values[*worst];
    Characteristic c{
        zone.name,          method, 2.0 * std::abs(largest), 2.0 * u95_of_worst(contour[*worst], section), limit,
        Decision::reported, {}};
    c.note = worst_note(largest, contour[*worst].position_mm);
    if (const auto note = systematic_note(contour[*worst].offset_error_mm); !note.empty()) c.note += "; " + note;
    if (const auto share = static_cast<double>(points - judged) / static_cast<double>(points); share > shown_share)
        c.note += "; " + core::fixed(100.0 * share, 1) + " % of it " + not_reached;
    if (limit) c.decision = decide(*c.value_mm, *c.u95_mm, *limit);
    return c;
}

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

Characteristic edge_radius(const char* name, const fitting::EdgeFit& edge, double error) {
    const std::string method = radius_method_of(edge.model);
    if (!edge.valid) return not_evaluable(name, method, {}, edge.why.empty() ? "no circular edge" : edge.why);
    return reported(name, method, edge.radius_mm, edge.radius_u95_mm + error,
                    "arc of " + core::fixed(core::deg_from_rad(edge.arc_angle_rad), 0) + " deg, rms " +
                        core::length_text(edge.rms_mm) + model_note(edge));
}

const ContourPoint& nearest_to(const std::vector<ContourPoint>& contour, const Vector2d& point) {
    const auto nearer = [&](const ContourPoint& a, const ContourPoint& b) {
        return (a.position_mm - point).squaredNorm() < (b.position_mm - point).squaredNorm();
    };
    return *std::min_element(contour.begin(), contour.end(), nearer);
}

/// The uncertainties of a size between two surfaces: noise in quadrature, offset errors added, as both have one sign.
double size_u95(const ContourPoint& a, const ContourPoint& b) {
    return std::hypot(a.u95_mm - a.offset_error_mm, b.u95_mm - b.offset_error_mm) + a.offset_error_mm +
           b.offset_error_mm;
}

void add_sizes(SectionResult& section) {
    const auto& fit = *section.fit;
    const auto& le = nearest_to(fit.contour, fit.le_point_mm);
    const auto& te = nearest_to(fit.contour, fit.te_point_mm);
    section.characteristics.push_back(edge_radius("le_radius", fit.le, le.offset_error_mm));
    section.characteristics.push_back(edge_radius("te_radius", fit.te, te.offset_error_mm));
    section.characteristics.push_back(reported("chord", chord_method, fit.chord_mm, size_u95(le, te),
                                               systematic_note(le.offset_error_mm + te.offset_error_mm)));
    const auto& worst = *std::max_element(fit.contour.begin(), fit.contour.end(), [](const auto& a, const auto& b) {
        const auto of_side = [](const ContourPoint& p) {
            return p.zone == Zone::suction || p.zone == Zone::pressure ? p.u95_mm : -1.0;
        };
        return of_side(a) < of_side(b);
    });
    section.characteristics.push_back(reported("max_thickness", thickness_method, fit.max_thickness_mm,
                                               size_u95(worst, worst), systematic_note(2.0 * worst.offset_error_mm)));
}

void add_nothing_evaluable(SectionResult& section, bool with_profiles, const EvaluationOptions& options) {
    auto& out = section.characteristics;
    if (with_profiles) {
        for (const auto& zone : profile_zones) {
            out.push_back(not_evaluable(zone.name, profile_method_of(options.filters.at(zone.zone)),
                                        limit_of(zone, options), section.why));
        }
    }
    out.push_back(not_evaluable("le_radius", radius_method, {}, section.why));
    out.push_back(not_evaluable("te_radius", radius_method, {}, section.why));
    out.push_back(not_evaluable("chord", chord_method, {}, section.why));
    out.push_back(not_evaluable("max_thickness", thickness_method, {}, section.why));
}

void take_fit(SectionResult& section, core::Result<fitting::SectionFit> fit) {
    if (!fit) {
        section.why = fit.error().text();
        return;
    }
    if (fit->verdicts.size() == section.points.size()) {
        for (std::size_t i = 0; i < section.points.size(); ++i)
            section.points[i].verdict = fit->verdicts[i];
    }
    section.fit = std::move(*fit);
    if (!section.closed()) section.why = "the section is not closed";
}

}  // namespace

double guard_band_mm(double u95_mm) {
    return guard_share * u95_mm;
}

Decision decide(double value_mm, double u95_mm, double limit_mm) {
    const double g = guard_band_mm(u95_mm);
    if (value_mm + g <= limit_mm) return Decision::accept;
    return value_mm - g > limit_mm ? Decision::reject : Decision::undecided;
}

SectionResult evaluate_section(SectionResult section, core::Result<fitting::SectionFit> fit,
                               const ReferenceContour* nominal, const EvaluationOptions& options) {
    section.characteristics.clear();
    take_fit(section, std::move(fit));
    if (nominal != nullptr) section.nominal_contour = nominal->points();
    if (!section.why.empty()) {
        add_nothing_evaluable(section, nominal != nullptr, options);
        return section;
    }
    if (nominal != nullptr) {
        section.deviation_mm = nominal->compare(section.fit->contour);
        const auto filtered = fitting::filter_zones(section.fit->contour, section.deviation_mm, options.filters);
        for (const auto& zone : profile_zones)
            section.characteristics.push_back(profile(zone, section, filtered, options));
    }
    add_sizes(section);
    return section;
}

void reject_by(const Exceedance& exceedance, SectionResult& section) {
    const auto zone = std::find_if(profile_zones.begin(), profile_zones.end(),
                                   [&](const ProfileZone& z) { return z.zone == exceedance.zone; });
    const auto at = std::find_if(section.characteristics.begin(), section.characteristics.end(),
                                 [&](const Characteristic& c) { return c.name == zone->name; });
    if (at == section.characteristics.end()) return;
    at->value_mm = 2.0 * std::abs(exceedance.deviation_mm);
    at->u95_mm = 2.0 * exceedance.guard_mm / guard_share;
    at->limit_mm = exceedance.limit_mm;
    at->decision = Decision::reject;
    at->note = worst_note(exceedance.deviation_mm, exceedance.position_mm) + "; " +
               std::to_string(ToleranceWatch::in_a_row) +
               " points in a row are out; not the whole section was measured";
}

}  // namespace cmm::acquisition
