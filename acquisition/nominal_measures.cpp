// SPDX-License-Identifier: Apache-2.0
#include "acquisition/nominal_measures.hpp"

#include <cmath>
#include <utility>

#include "acquisition/curvature_extreme.hpp"
#include "fitting/area_measures.hpp"
#include "fitting/chord.hpp"
#include "fitting/edge_radius.hpp"
#include "fitting/throat.hpp"

namespace cmm::acquisition {
namespace {

using fitting::Measure;
using Kind = CharacteristicKind;

constexpr std::size_t nominal_points = 1200;  // exact ones, with tangents: between them the error is below a nanometre
constexpr double spread_by_turning = 0.25;    // as measured contours are sampled

tl::unexpected<core::Error> not_measured(const std::string& why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, why);
}

}  // namespace

fitting::SectionFit section_of_nominal(const fitting::NominalSection& nominal) {
    fitting::SectionFit fit;
    const auto& curve = nominal.curve();
    // Fine steps of length, then equal steps of a mixed measure of length and turning.
    const std::size_t fine = 2 * nominal_points;
    std::vector<fitting::CurvePoint> at(fine + 1);
    std::vector<double> turn(fine + 1, 0.0);
    for (std::size_t k = 0; k <= fine; ++k) {
        const double s = curve.length() * static_cast<double>(k) / static_cast<double>(fine);
        at[k] = curve.evaluate(nominal.le_mm() + s);
        if (k > 0) turn[k] = turn[k - 1] + std::abs(fitting::turn_between(at[k - 1].normal, at[k].normal));
    }
    std::size_t k = 0;
    for (std::size_t i = 0; i < nominal_points; ++i) {
        const double wanted = static_cast<double>(i) / static_cast<double>(nominal_points);
        const auto measure = [&](std::size_t j) {
            return (1.0 - spread_by_turning) * static_cast<double>(j) / static_cast<double>(fine) +
                   spread_by_turning * turn[j] / turn[fine];
        };
        while (k + 1 < fine && measure(k + 1) <= wanted)
            ++k;
        const double share = (wanted - measure(k)) / (measure(k + 1) - measure(k));
        const double s = curve.length() * (static_cast<double>(k) + share) / static_cast<double>(fine);
        const auto place = curve.evaluate(nominal.le_mm() + s);
        fitting::ContourPoint point;
        point.position_mm = place.position;
        point.normal = place.normal;
        point.zone = nominal.zone_at(curve.wrap(nominal.le_mm() + s));
        point.arc_length_mm = s;
        fit.contour.push_back(point);
    }
    fit.le_point_mm = nominal.le_point();
    fit.te_point_mm = nominal.te_point();
    fit.le_scale_mm = nominal.le_radius_mm();
    fit.te_scale_mm = nominal.te_radius_mm();
    fit.le.why = fit.te.why = "a nominal has no fitted circle";
    return fit;
}

fitting::EdgeName edge_of(const CharacteristicSpec& spec) {
    return spec.kind == Kind::le_radius ? fitting::EdgeName::le : fitting::EdgeName::te;
}

core::Result<Measure> measure_of(const CharacteristicSpec& spec, fitting::MeasuredSection& section) {
    switch (spec.kind) {
        case Kind::chord:
            return fitting::measure_chord(section, spec.chord, spec.direction_rad);
        case Kind::axial_chord:
            return fitting::measure_chord(section, fitting::ChordMethod::x_axis);
        case Kind::stagger:
            return fitting::measure_stagger(section, spec.stagger);
        case Kind::max_thickness:
            return fitting::measure_max_thickness(section);
        case Kind::max_thickness_position:
            return fitting::measure_max_thickness_position(section, spec.position);
        case Kind::le_thickness:
            return fitting::measure_edge_thickness(section, fitting::EdgeName::le, spec.distance_mm);
        case Kind::te_thickness:
            return fitting::measure_edge_thickness(section, fitting::EdgeName::te, spec.distance_mm);
        case Kind::le_angle:
            return fitting::measure_edge_angle(section, fitting::EdgeName::le, spec.near_mm, spec.far_mm,
                                               spec.reference);
        case Kind::te_angle:
            return fitting::measure_edge_angle(section, fitting::EdgeName::te, spec.near_mm, spec.far_mm,
                                               spec.reference);
        case Kind::area:
            return fitting::measure_area(section).area;
        case Kind::centroid_x:
            return fitting::measure_area(section).centroid_x;
        case Kind::centroid_y:
            return fitting::measure_area(section).centroid_y;
        case Kind::throat:
            return fitting::measure_throat(
                section, spec.pitch_mm * fitting::Vec2(std::cos(spec.direction_rad), std::sin(spec.direction_rad)));
        default:
            return not_measured("no measure of the contour alone");
    }
}

std::optional<double> nominal_without_section(const CharacteristicSpec& spec) {
    if (is_zone_width(spec.kind)) return std::nullopt;
    return needs_best_fit(spec.kind) ? spec.nominal.value_or(0.0) : spec.nominal;
}

NominalMeasures::NominalMeasures(const fitting::NominalSection& nominal, std::size_t index,
                                 std::span<const CharacteristicSpec> asked)
    : fit_(section_of_nominal(nominal)), measured_(fit_) {
    for (const auto& spec : asked)
        if (spec.is_of(index) && !is_of_part(spec.kind) && !is_zone_width(spec.kind) && !nominal_without_section(spec))
            known_.emplace_back(spec, value_of(spec, nominal));
}

core::Result<double> NominalMeasures::value_of(const CharacteristicSpec& spec, const fitting::NominalSection& nominal) {
    if (spec.has_radius_window()) {
        const auto found = fitting::measure_edge_radius(measured_, edge_of(spec), spec.radius);
        if (!found) return not_measured("of the nominal section: " + found.error().message);
        return found->radius.value;
    }
    if (spec.kind == Kind::le_radius || spec.kind == Kind::te_radius)
        return not_measured("a radius is by the form that the points of the part support");
    if (is_curvature(spec.kind)) return curvature_of_nominal(spec, nominal, contour());
    const auto measured = measure_of(spec, measured_);
    if (!measured) return not_measured("of the nominal section: " + measured.error().message);
    return measured->value;
}

const core::Result<double>* NominalMeasures::find(const CharacteristicSpec& spec) const {
    for (const auto& [known, value] : known_)
        if (known == spec) return &value;
    return nullptr;
}

}  // namespace cmm::acquisition
