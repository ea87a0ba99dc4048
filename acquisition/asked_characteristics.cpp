// SPDX-License-Identifier: Apache-2.0
#include "acquisition/asked_characteristics.hpp"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "acquisition/curvature_extreme.hpp"
#include "acquisition/evaluation.hpp"
#include "acquisition/section_alignment.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "fitting/area_measures.hpp"
#include "fitting/chord.hpp"
#include "fitting/throat.hpp"

namespace cmm::acquisition {
namespace {

using fitting::Measure;
using Kind = CharacteristicKind;

constexpr std::size_t nominal_points = 1200;  // exact ones, with tangents: between them the error is below a nanometre
constexpr double spread_by_turning = 0.25;    // as measured contours are sampled

tl::unexpected<core::Error> refuse(const std::string& why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, why);
}

fitting::EdgeName edge_of(const CharacteristicSpec& spec) {
    return spec.kind == Kind::le_radius ? fitting::EdgeName::le : fitting::EdgeName::te;
}

/// Angles that differ by whole turns are the same.
double near(double value, double reference, Unit unit) {
    return unit == Unit::rad ? reference + std::remainder(value - reference, 2.0 * std::numbers::pi) : value;
}

}  // namespace

fitting::SectionFit section_of_nominal(const fitting::NominalSection& nominal) {
    fitting::SectionFit fit;
    fit.closed = true;
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

AskedCharacteristics::AskedCharacteristics(fitting::MeasuredSection& section,
                                           std::span<const std::optional<double>> deviation_mm,
                                           const fitting::NominalSection* nominal, FormProfile form,
                                           const DecisionRule& rule, const fitting::Datum* datum)
    : section_(section),
      deviation_mm_(deviation_mm),
      nominal_(nominal),
      form_(std::move(form)),
      rule_(rule),
      datum_(datum) {}

fitting::NumberUncertainty AskedCharacteristics::uncertainty(const Measure& measure) const {
    return section_.uncertainty(datum_ != nullptr ? datum_->of_aligned(measure, section_.contour()) : measure);
}

core::Result<Measure> AskedCharacteristics::measure(const CharacteristicSpec& spec, fitting::MeasuredSection& section) {
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
            return refuse("no measure of the contour alone");
    }
}

const core::Result<fitting::BestFit>& AskedCharacteristics::best_fit(const ZoneSet& zones) {
    if (const auto known = best_fits_.find(zones); known != best_fits_.end()) return known->second;
    core::Result<fitting::BestFit> fit = refuse("there is no nominal");
    if (nominal_ != nullptr) {
        fitting::BestFitOptions options;
        options.zones = zones;
        fit = fitting::fit_to_nominal(section_.contour(), nominal_->curve(), options, reached(deviation_mm_));
    }
    return best_fits_.emplace(zones, std::move(fit)).first->second;
}

fitting::MeasuredSection& AskedCharacteristics::nominal_section() {
    if (!nominal_section_) {
        nominal_fit_.emplace(section_of_nominal(*nominal_));
        nominal_section_.emplace(*nominal_fit_);
    }
    return *nominal_section_;
}

core::Result<double> AskedCharacteristics::nominal_of(const CharacteristicSpec& spec) {
    if (const auto known = nominal_without_section(spec)) return *known;
    if (nominal_ == nullptr) return refuse("no nominal is given, and there is no nominal section");
    if (spec.has_radius_window()) {
        const auto found = fitting::measure_edge_radius(nominal_section(), edge_of(spec), spec.radius);
        if (!found) return refuse("of the nominal section: " + found.error().message);
        return found->radius.value;
    }
    if (spec.kind == Kind::le_radius) return nominal_->le_radius_mm();
    if (spec.kind == Kind::te_radius) return nominal_->te_radius_mm();
    if (is_curvature(spec.kind)) return curvature_of_nominal(spec, *nominal_, nominal_section().contour());
    const auto measured = measure(spec, nominal_section());
    if (!measured) return refuse("of the nominal section: " + measured.error().message);
    return measured->value;
}

Characteristic AskedCharacteristics::radius_in_window(const CharacteristicSpec& spec) {
    const auto found = fitting::measure_edge_radius(section_, edge_of(spec), spec.radius);
    if (!found) return not_evaluable("", std::string(to_string(spec.kind)), {}, found.error().message);
    Characteristic c;
    c.method = found->radius.method;
    const auto u = uncertainty(found->radius);
    c.value = found->radius.value;
    take_uncertainty(u, section_.fit().contour_noise, c);
    c.note = "arc of " + core::fixed(core::deg_from_rad(found->arc_rad), 0) + " deg" +
             (spec.radius.reach_mm ? " within " + core::fixed(*spec.radius.reach_mm, 3) + " mm of the nose" : "") +
             ", rms " + core::length_text(found->rms_mm);
    if (const auto offset = offset_error_note(u.offset_error, Unit::mm); !offset.empty()) c.note += "; " + offset;
    return c;
}

Characteristic AskedCharacteristics::curvature(const CharacteristicSpec& spec) {
    if (nominal_ == nullptr && !needs_best_fit(spec.kind)) return curvature_extreme(spec, section_, nullptr, rule_);
    const auto& fit = best_fit(spec.fit_zones);
    if (!fit) {
        auto c = not_evaluable("", std::string(to_string(spec.kind)), {}, fit.error().message);
        c.unit = unit_of(spec.kind);
        return c;
    }
    const CurvatureNominal nominal{*nominal_, nominal_section().contour(), fit->motion};
    return curvature_extreme(spec, section_, &nominal, rule_);
}

std::optional<SectionPlacement> AskedCharacteristics::placement(const ZoneSet& zones) {
    const auto& fit = best_fit(zones);
    if (!fit) return std::nullopt;
    const fitting::MeasuredSection* const section = &section_;
    const auto datum = fitting::datums_of(*fit, {&section, 1});
    return SectionPlacement{fit->motion.shift_mm, fit->motion.turn_rad, datum.front().covariance,
                            datum.front().places, datum.front().loads,  zones};
}

Characteristic AskedCharacteristics::by_best_fit(const CharacteristicSpec& spec) {
    const auto& fit = best_fit(spec.fit_zones);
    Characteristic c;
    if (fit && is_profile_form(spec.kind)) {
        c = form_(spec, *fit);
        c.method += fit_zone_words(spec);
        return c;
    }
    c.unit = unit_of(spec.kind);
    c.method = (is_profile_form(spec.kind) ? "line profile ISO 1101, 2 max|d|, after the best fit"
                                           : "BESTFIT: least squares along the normals, weighted by arc length") +
               fit_zone_words(spec);
    if (!fit) {
        c.decision = Decision::not_evaluable;
        c.note = fit.error().message;
        return c;
    }
    const Measure& measure = spec.kind == Kind::twist            ? fit->twist
                             : spec.kind == Kind::displacement_x ? fit->dx
                                                                 : fit->dy;
    c.value = measure.value;
    take_uncertainty(uncertainty(measure), section_.fit().contour_noise, c);
    c.note = "of the section against its nominal, about x " + core::fixed(fit->motion.about_mm.x(), 3) + " mm, y " +
             core::fixed(fit->motion.about_mm.y(), 3) + " mm; " + core::length_text(fit->rms_mm) + " rms are left";
    return c;
}

std::string fit_zone_words(const CharacteristicSpec& spec) {
    const std::string words = zone_words(spec.fit_zones);
    return words.empty() ? words : "; best fit of " + words;
}

std::optional<double> nominal_without_section(const CharacteristicSpec& spec) {
    if (is_zone_width(spec.kind)) return std::nullopt;
    return needs_best_fit(spec.kind) ? spec.nominal.value_or(0.0) : spec.nominal;
}

void set_limits(const CharacteristicSpec& spec, Characteristic& c) {
    c.required = spec.has_tolerance();
    if (!c.nominal && !is_zone_width(spec.kind)) return;
    const double from = c.nominal.value_or(0.0);
    if (spec.above) c.upper = from + *spec.above;
    if (spec.below) c.lower = from + *spec.below;
}

/// Nominal, limits and decision.
void AskedCharacteristics::require(const CharacteristicSpec& spec, Characteristic& c) {
    if (!is_zone_width(spec.kind)) {
        const auto nominal = nominal_of(spec);
        if (nominal) {
            c.nominal = *nominal;
            if (c.value) c.value = near(*c.value, *nominal, c.unit);
        } else if (spec.has_tolerance()) {
            c.note = nominal.error().message;
            c.value.reset();
            c.u95.reset();
            c.budget.reset();
            c.decision = Decision::not_evaluable;
        }
    }
    set_limits(spec, c);
    decide(c, rule_);
}

Characteristic AskedCharacteristics::make(const CharacteristicSpec& spec, const SectionResult& known) {
    Characteristic c;
    if (spec.has_radius_window()) {
        c = radius_in_window(spec);
    } else if (spec.kind == Kind::le_radius || spec.kind == Kind::te_radius) {
        if (const auto* radius = known.find(to_string(spec.kind)); radius != nullptr) c = *radius;
    } else if (is_curvature(spec.kind)) {
        c = curvature(spec);
    } else if (needs_best_fit(spec.kind)) {
        c = by_best_fit(spec);
    } else {
        const auto measured = measure(spec, section_);
        if (measured) {
            c.method = measured->method;
            const auto u = uncertainty(*measured);
            c.value = measured->value;
            take_uncertainty(u, section_.fit().contour_noise, c);
            c.note = offset_error_note(u.offset_error, unit_of(spec.kind));
        } else {
            c.method = to_string(spec.kind);
            c.decision = Decision::not_evaluable;
            c.note = measured.error().message;
        }
    }
    c.name = spec.label;
    c.unit = unit_of(spec.kind);
    if (datum_ != nullptr && is_position(spec))
        c.note += (c.note.empty() ? "" : "; ") + std::string("of the aligned blade");
    require(spec, c);
    return c;
}

}  // namespace cmm::acquisition
