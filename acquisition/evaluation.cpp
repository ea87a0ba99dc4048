// SPDX-License-Identifier: Apache-2.0
#include "acquisition/evaluation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "acquisition/asked_characteristics.hpp"
#include "acquisition/point_tolerance.hpp"
#include "acquisition/points_out.hpp"
#include "acquisition/profile.hpp"
#include "acquisition/section_sizes.hpp"
#include "acquisition/span_point.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using fitting::ContourPoint;
using fitting::Zone;

/// The profiles after the best fit: the contour is carried into the frame of the nominal, once for all zones that end
/// at the same places.
class FormProfiles {
  public:
    /// `measured`: of which the best fit is.
    FormProfiles(const SectionResult& section, const fitting::MeasuredSection& measured,
                 const ReferenceContour* nominal, const fitting::NominalSection* curve,
                 const EvaluationOptions& options)
        : section_(section), measured_(measured), nominal_(nominal), curve_(curve) {
        unlimited_.filters = options.filters;
        unlimited_.rule = options.rule;
    }

    Characteristic of(const CharacteristicSpec& spec, const fitting::BestFit& fit) {
        const Changes changes{spec.le_change_mm, spec.te_change_mm};
        if (moved_.empty() || changes != changes_ || spec.fit_zones != fit_zones_) compare(fit, changes);
        fit_zones_ = spec.fit_zones;
        constexpr std::array zones{Zone::le, Zone::suction, Zone::te, Zone::pressure};
        const auto first = static_cast<std::size_t>(CharacteristicKind::profile_form_le);
        const Zone zone = zones[static_cast<std::size_t>(spec.kind) - first];
        const auto& of_zone = *std::find_if(profile_zones.begin(), profile_zones.end(),
                                            [&](const ProfileZone& z) { return z.zone == zone; });
        return profile(of_zone, section_, {moved_, filtered_, unaligned_, frame()}, unlimited_);
    }

  private:
    /// How far from their noses LE and TE reach.
    using Changes = std::array<std::optional<double>, 2>;

    std::string frame() const {
        std::string text = "after the best fit of the section";
        for (std::size_t k = 0; k < changes_.size(); ++k)
            if (changes_[k])
                text +=
                    std::string(k == 0 ? ", LE" : ", TE") + " to " + core::fixed(*changes_[k], 3) + " mm from its nose";
        return text;
    }

    /// Within that distance of the nominal's nose is the edge, beyond it the side.
    void change_zones() {
        if (!changes_[0] && !changes_[1]) return;
        const std::array edges{Zone::le, Zone::te};
        const std::array noses{curve_->le_point(), curve_->te_point()};
        std::optional<double> near_mm;
        for (auto& point : moved_) {
            const double s_mm = curve_->curve().closest(point.position_mm, near_mm).s_mm;
            near_mm = s_mm;
            for (std::size_t k = 0; k < edges.size(); ++k) {
                if (!changes_[k]) continue;
                if ((point.position_mm - noses[k]).norm() <= *changes_[k])
                    point.zone = edges[k];
                else if (point.zone == edges[k])
                    point.zone = curve_->side_at(s_mm);
            }
        }
    }

    void compare(const fitting::BestFit& fit, const Changes& changes) {
        changes_ = changes;
        moved_ = measured_.fit().contour;
        if (const auto& noise = measured_.fit().contour_noise; noise.has_fields()) {
            const fitting::MeasuredSection* const only = &measured_;
            fitting::set_place_errors(moved_, noise, &fitting::datums_of(fit, {&only, 1}).front());
        }
        for (auto& point : moved_) {
            point.position_mm = fit.motion.undo(point.position_mm);
            point.normal = fit.motion.undo_on_direction(point.normal);
        }
        change_zones();
        auto compared = moved_;  // takes the offset error of the nominal's lean, which the contour has already
        filtered_ = fitting::filter_zones(moved_, nominal_->compare(compared), unlimited_.filters);
    }

    const SectionResult& section_;
    const fitting::MeasuredSection& measured_;
    const ReferenceContour* nominal_;
    const fitting::NominalSection* curve_;
    Changes changes_;
    ZoneSet fit_zones_ = all_zones;
    EvaluationOptions unlimited_;
    Alignment unaligned_;
    std::vector<ContourPoint> moved_;
    fitting::FilteredZones filtered_;
};

void replace_or_add(Characteristic c, SectionResult& section) {
    auto& all = section.characteristics;
    const auto same = std::find_if(all.begin(), all.end(), [&](const auto& known) { return known.name == c.name; });
    if (same == all.end())
        all.push_back(std::move(c));
    else
        *same = std::move(c);
}

void add_asked(SectionResult& section, fitting::MeasuredSection& measured, const ReferenceContour* nominal,
               const fitting::NominalSection* curve, const EvaluationOptions& options, const fitting::Datum* datum) {
    FormProfiles forms(section, measured, nominal, curve, options);
    const auto form = [&](const CharacteristicSpec& spec, const fitting::BestFit& fit) { return forms.of(spec, fit); };
    const fitting::NominalSection* const of_nominal = nominal != nullptr ? curve : nullptr;
    std::optional<NominalMeasures> own;
    const NominalMeasures* measures = options.nominal_measures;
    if (measures == nullptr && of_nominal != nullptr && !options.asked.empty())
        measures = &own.emplace(*of_nominal, section.index, options.asked);
    AskedCharacteristics asked(measured, section.deviation_mm, of_nominal, measures, form, options.rule, datum);
    for (const auto& spec : options.asked) {
        if (spec.kind == CharacteristicKind::points_out) {
            if (spec.is_of(section.index)) replace_or_add(points_out(spec, section, options), section);
        } else if (!is_of_part(spec.kind)) {
            if (spec.is_of(section.index)) replace_or_add(asked.make(spec, section), section);
        } else if (spec.kind != CharacteristicKind::generatrix) {
            if (section.placement(spec.fit_zones) != nullptr) continue;
            if (auto placed = asked.placement(spec.fit_zones)) section.placements.push_back(*placed);
        } else if (nominal != nullptr && section.alignment.state != Alignment::State::refused) {
            if (auto point = span_point(*section.fit, *curve, section.alignment, spec))
                section.span_points.push_back(std::move(*point));
        }
    }
}

/// What was asked for of a section that has no contour.
void add_asked_not_evaluable(SectionResult& section, const EvaluationOptions& options) {
    for (const auto& spec : options.asked) {
        if (is_of_part(spec.kind) || !spec.is_of(section.index)) continue;
        auto c = not_evaluable(spec.label, std::string(to_string(spec.kind)), {}, section.why);
        c.unit = unit_of(spec.kind);
        c.nominal = nominal_without_section(spec);
        set_limits(spec, c);
        replace_or_add(std::move(c), section);
    }
}

void add_profiles_not_evaluable(SectionResult& section, const ReferenceContour& nominal,
                                const EvaluationOptions& options, const std::string& why) {
    for (const auto& zone : profile_zones)
        section.characteristics.push_back(profile_not_evaluable(zone, options, why));
    if (nominal.has_tolerances()) section.characteristics.push_back(point_tolerance_not_evaluable(options, why));
}

void add_nothing_evaluable(SectionResult& section, const ReferenceContour* nominal, const EvaluationOptions& options) {
    if (nominal != nullptr) add_profiles_not_evaluable(section, *nominal, options, section.why);
    add_sizes_not_evaluable(section);
    add_asked_not_evaluable(section, options);
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
    if (!section.has_contour()) section.why = "the section is not closed";
}

/// How the surface rises where the contour does not know it: as the nominal does.
void know_rise(const ReferenceContour& nominal, std::vector<ContourPoint>& contour) {
    auto compared = contour;
    (void)nominal.compare(compared);
    for (std::size_t i = 0; i < contour.size(); ++i)
        contour[i].rise = compared[i].rise;
}

/// What machine, probe and temperature do to each place, after the alignment (nullptr: as measured).
void add_place_errors(fitting::SectionFit& fit, const fitting::Datum* datum) {
    if (fit.contour_noise.has_fields()) fitting::set_place_errors(fit.contour, fit.contour_noise, datum);
}

/// By the blade's alignment where that is known, else by the section's own.
void align(const ReferenceContour& nominal, const fitting::NominalSection* curve, const EvaluationOptions& options,
           const SectionAlignment* shared, SectionResult& section) {
    const fitting::Datum* datum = nullptr;
    core::Result<SectionAlignment> own;
    if (shared != nullptr) {
        section.alignment = shared->alignment;
        if (!section.alignment.done()) return;
        datum = &shared->datum;
    } else {
        own = align_section(*section.fit, nominal, curve->curve(), options.alignment,
                            {options.profile_mm, options.edge_profile_mm});
        if (!own) {
            section.alignment.state = Alignment::State::refused;
            section.alignment.spec = options.alignment;
            section.alignment.note = own.error().message;
            return;
        }
        section.alignment = own->alignment;
        datum = &own->datum;
        if (options.alignment.kind == AlignmentKind::blade) {
            section.alignment.state = Alignment::State::provisional;
            section.alignment.note = "by this section alone";
        }
    }
    add_place_errors(*section.fit, datum);
    for (auto& point : section.nominal_contour)
        point = section.alignment.motion.apply(point);
}

/// The deviations, after the alignment.
void compare_with(const ReferenceContour& nominal, const EvaluationOptions& options, SectionResult& section) {
    auto& contour = section.fit->contour;
    if (options.alignment.kind == AlignmentKind::none) {
        section.deviation_mm = nominal.compare(contour, options.lean);
    } else if (section.alignment.done()) {
        section.deviation_mm = compare_aligned(contour, nominal, section.alignment.motion, options.lean);
    } else {
        // Sizes do not mind how the section lies; what the 2-D offset makes too thick is told by the wall next to it.
        static_cast<void>(nominal.compare(contour, options.lean));
    }
}

/// Numbers answer to a wrong height as the walls lean; deviations have it from the alignment.
void take_plane(const ReferenceContour& nominal, const EvaluationOptions& options, fitting::SectionFit& fit) {
    if (!options.plane) return;
    const auto leans = nominal.leans_along(fit.contour);
    fit.contour_noise.take(fitting::PlaneError(fit.contour, leans, *options.plane));
}

void add_profiles(SectionResult& section, const ReferenceContour& nominal, const EvaluationOptions& options) {
    if (section.alignment.state == Alignment::State::refused)
        return add_profiles_not_evaluable(section, nominal, options, section.alignment.note);
    const std::string frame = frame_words(options.alignment);
    const auto& contour = section.fit->contour;
    const auto filtered = fitting::filter_zones(contour, section.deviation_mm, options.filters);
    const Compared compared{contour, filtered, section.alignment, frame};
    for (const auto& zone : profile_zones)
        section.characteristics.push_back(profile(zone, section, compared, options));
    if (!nominal.has_tolerances()) return;
    section.tolerances = tolerances_along(section, nominal);
    section.characteristics.push_back(point_tolerance(section, compared, options));
}

/// The profiles that are out however the section is moved: after the motion that brings it as far into its zones as can
/// be, which is freer than any of the whole blade. None of those that a filter judges.
std::vector<Characteristic> out_for_certain(const SectionResult& section, const ReferenceContour& nominal,
                                            const fitting::NominalSection& curve, const EvaluationOptions& options) {
    AlignmentSpec best;
    best.kind = AlignmentKind::section;
    best.objective = fitting::FitObjective::into_tolerance;
    ProfileWidths widths{options.profile_mm, options.edge_profile_mm};
    if (options.filters.at(Zone::suction).kind != fitting::FilterKind::none) widths.side_mm.reset();
    if (options.filters.at(Zone::le).kind != fitting::FilterKind::none) widths.edge_mm.reset();
    const auto aligned = align_section(*section.fit, nominal, curve.curve(), best, widths);
    if (!aligned) return {};
    auto contour = section.fit->contour;
    const auto& noise = section.fit->contour_noise;
    if (noise.has_fields()) fitting::set_place_errors(contour, noise, &aligned->datum);
    const auto deviation = compare_aligned(contour, nominal, aligned->alignment.motion, options.lean);
    const auto filtered = fitting::filter_zones(contour, deviation, {});
    std::vector<Characteristic> out;
    for (const auto& zone : profile_zones) {
        if (!(zone.edge ? widths.edge_mm : widths.side_mm)) continue;
        auto c = profile(zone, section, {contour, filtered, aligned->alignment, frame_words(best)}, options);
        if (c.decision != Decision::reject) continue;
        c.note += "; no motion of the blade brings it in";
        out.push_back(std::move(c));
    }
    return out;
}

/// What may still change with the alignment of the blade is not decided yet.
void leave_open(SectionResult& section, const ReferenceContour& nominal, const fitting::NominalSection& curve,
                const EvaluationOptions& options) {
    std::vector<std::string_view> names{point_tolerance_name};
    for (const auto& zone : profile_zones)
        names.emplace_back(zone.name);
    for (const auto& spec : options.asked)
        if (spec.is_of(section.index) && is_position(spec)) names.emplace_back(spec.label);
    bool out = false;
    for (auto& c : section.characteristics) {
        if (std::find(names.begin(), names.end(), c.name) == names.end()) continue;
        if (c.decision != Decision::accept && c.decision != Decision::reject) continue;
        out = out || c.decision == Decision::reject;
        c.decision = Decision::undecided;
        c.note += "; provisional until the whole blade is aligned";
    }
    if (!out) return;
    for (auto& certain : out_for_certain(section, nominal, curve, options)) {
        const auto same = std::find_if(section.characteristics.begin(), section.characteristics.end(),
                                       [&](const Characteristic& c) { return c.name == certain.name; });
        if (same != section.characteristics.end()) *same = std::move(certain);
    }
}

}  // namespace

SectionResult lay_section(SectionResult section, core::Result<fitting::SectionFit> fit, const ReferenceContour* nominal,
                          const EvaluationOptions& options, const fitting::NominalSection* curve,
                          const SectionAlignment* shared) {
    section.alignment = {};
    take_fit(section, std::move(fit));
    if (nominal != nullptr) section.nominal_contour = nominal->points();
    if (!section.why.empty()) return section;
    if (nominal != nullptr && section.fit->contour_noise.has_fields()) know_rise(*nominal, section.fit->contour);
    add_place_errors(*section.fit, nullptr);
    if (nominal != nullptr && options.alignment.kind != AlignmentKind::none)
        align(*nominal, curve, options, shared, section);
    return section;
}

SectionResult judge_section(SectionResult section, const ReferenceContour* nominal, const EvaluationOptions& options,
                            const fitting::NominalSection* curve, const SectionAlignment* shared) {
    section.characteristics.clear();
    section.deviation_mm.clear();
    section.tolerances.clear();
    section.placements.clear();
    section.span_points.clear();
    if (!section.why.empty()) {
        add_nothing_evaluable(section, nominal, options);
        return section;
    }
    fitting::fit_edges(*section.fit);
    if (nominal != nullptr) {
        compare_with(*nominal, options, section);
        take_plane(*nominal, options, *section.fit);
        add_profiles(section, *nominal, options);
    }
    // Positions are those in the frame of the blade, where it has one; the contour of the result stays as measured.
    std::optional<fitting::SectionFit> in_datum;
    const fitting::Datum* datum = shared != nullptr && shared->alignment.done() ? &shared->datum : nullptr;
    if (datum != nullptr) in_datum = fitting::undone(*section.fit, datum->motion);
    fitting::MeasuredSection measured(in_datum ? *in_datum : *section.fit);
    add_sizes(section, measured, options);
    add_asked(section, measured, nominal, curve, options, datum);
    if (nominal != nullptr && section.alignment.state == Alignment::State::provisional)
        leave_open(section, *nominal, *curve, options);
    return section;
}

SectionResult evaluate_section(SectionResult section, core::Result<fitting::SectionFit> fit,
                               const ReferenceContour* nominal, const EvaluationOptions& options,
                               const fitting::NominalSection* curve, const SectionAlignment* shared) {
    return judge_section(lay_section(std::move(section), std::move(fit), nominal, options, curve, shared), nominal,
                         options, curve, shared);
}

void reject_by(const Exceedance& exceedance, SectionResult& section) {
    const auto zone = std::find_if(profile_zones.begin(), profile_zones.end(),
                                   [&](const ProfileZone& z) { return z.zone == exceedance.zone; });
    const auto at = std::find_if(section.characteristics.begin(), section.characteristics.end(),
                                 [&](const Characteristic& c) { return c.name == zone->name; });
    if (at == section.characteristics.end()) return;
    at->value = 2.0 * std::abs(exceedance.deviation_mm);
    at->u95 = 2.0 * exceedance.guard_mm;
    at->guard_accept = at->guard_reject = at->u95;
    at->upper = exceedance.limit_mm;
    at->decision = Decision::reject;
    at->note = worst_note(exceedance.deviation_mm, exceedance.position_mm) + "; " +
               std::to_string(ToleranceWatch::in_a_row) +
               " points in a row are out; not the whole section was measured";
}

}  // namespace cmm::acquisition
