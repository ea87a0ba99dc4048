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
#include "fitting/nominal_radius.hpp"

namespace cmm::acquisition {
namespace {

using fitting::Measure;
using Kind = CharacteristicKind;

tl::unexpected<core::Error> refuse(const std::string& why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, why);
}

/// By what form the points of the edge support; so is that of the nominal, when the part has been measured.
bool is_plain_radius(const CharacteristicSpec& spec) {
    return (spec.kind == Kind::le_radius || spec.kind == Kind::te_radius) && !spec.has_radius_window();
}

/// Angles that differ by whole turns are the same.
double near(double value, double reference, Unit unit) {
    return unit == Unit::rad ? reference + std::remainder(value - reference, 2.0 * std::numbers::pi) : value;
}

}  // namespace

AskedCharacteristics::AskedCharacteristics(fitting::MeasuredSection& section,
                                           std::span<const std::optional<double>> deviation_mm,
                                           const fitting::NominalSection* nominal, const NominalMeasures* measures,
                                           FormProfile form, const DecisionRule& rule, const fitting::Datum* datum)
    : section_(section),
      deviation_mm_(deviation_mm),
      nominal_(nominal),
      measures_(measures),
      form_(std::move(form)),
      rule_(rule),
      datum_(datum) {}

fitting::NumberUncertainty AskedCharacteristics::uncertainty(const Measure& measure) const {
    return section_.uncertainty(datum_ != nullptr ? datum_->of_aligned(measure, section_.contour()) : measure);
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

core::Result<double> AskedCharacteristics::nominal_of(const CharacteristicSpec& spec) const {
    if (const auto known = nominal_without_section(spec)) return *known;
    if (nominal_ == nullptr) return refuse("no nominal is given, and there is no nominal section");
    if (is_plain_radius(spec)) return fitting::nominal_radius(*nominal_, edge_of(spec), section_.fit());
    if (spec.kind == Kind::chord && spec.chord == fitting::ChordMethod::rad_center)
        return fitting::nominal_rad_center(*nominal_, section_.fit());
    const auto* value = measures_->find(spec);
    return value != nullptr ? *value : refuse("the nominal section was not asked for it");
}

Characteristic AskedCharacteristics::radius_in_window(const CharacteristicSpec& spec) {
    const auto found = fitting::measure_edge_radius(section_, edge_of(spec), spec.radius);
    if (!found) return not_evaluable("", std::string(to_string(spec.kind)), {}, found.error().message);
    Characteristic c;
    c.method = found->radius.method;
    const auto u = uncertainty(found->radius);
    c.value = found->radius.value;
    c.note = "arc of " + core::fixed(core::deg_from_rad(found->arc_rad), 0) + " deg" +
             (spec.radius.reach_mm ? " within " + core::fixed(*spec.radius.reach_mm, 3) + " mm of the nose" : "") +
             ", rms " + core::length_text(found->rms_mm);
    if (const auto offset = offset_error_note(u.offset_error, Unit::mm); !offset.empty()) c.note += "; " + offset;
    take_uncertainty(u, section_.fit().contour_noise, c);
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
    const CurvatureNominal nominal{*nominal_, measures_->contour(), fit->motion};
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
    c.note = "of the section against its nominal, about x " + core::fixed(fit->motion.about_mm.x(), 3) + " mm, y " +
             core::fixed(fit->motion.about_mm.y(), 3) + " mm; " + core::length_text(fit->rms_mm) + " rms are left";
    take_uncertainty(uncertainty(measure), section_.fit().contour_noise, c);
    return c;
}

std::string fit_zone_words(const CharacteristicSpec& spec) {
    const std::string words = zone_words(spec.fit_zones);
    return words.empty() ? words : "; best fit of " + words;
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
        } else if (spec.has_tolerance() && c.value) {
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
    } else if (is_plain_radius(spec)) {
        if (const auto* radius = known.find(to_string(spec.kind)); radius != nullptr) c = *radius;
    } else if (is_curvature(spec.kind)) {
        c = curvature(spec);
    } else if (needs_best_fit(spec.kind)) {
        c = by_best_fit(spec);
    } else {
        const auto measured = measure_of(spec, section_);
        if (measured) {
            c.method = measured->method;
            const auto u = uncertainty(*measured);
            c.value = measured->value;
            c.note = offset_error_note(u.offset_error, unit_of(spec.kind));
            take_uncertainty(u, section_.fit().contour_noise, c);
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
