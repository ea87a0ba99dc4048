// SPDX-License-Identifier: Apache-2.0
#include "acquisition/evaluation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "acquisition/asked_characteristics.hpp"
#include "acquisition/span_point.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "fitting/chord.hpp"
#include "fitting/statistics.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using fitting::ContourPoint;
using fitting::Zone;

struct ProfileZone {
    Zone zone;
    const char* name;
    bool edge;
};
constexpr std::array profile_zones{
    ProfileZone{Zone::le, "profile_le", true}, ProfileZone{Zone::suction, "profile_suction", false},
    ProfileZone{Zone::te, "profile_te", true}, ProfileZone{Zone::pressure, "profile_pressure", false}};

constexpr double places_of_a_point = 3.0;
constexpr double shown_share = 0.0005;  // of a zone that is not evaluable: below 0.1 % nothing is said
constexpr const char* not_reached = "not evaluable there: the ball does not reach";
constexpr const char* profile_method = "line profile ISO 1101, 2 max|d|, ";
constexpr const char* radius_method = "orthogonal-distance circle through the edge's points";
constexpr const char* chord_method = "NOSETAIL: between the points where the camber line leaves the section";
constexpr const char* thickness_method = "MAX_INSCRIBED: diameter of the largest inscribed circle";

Characteristic not_evaluable(const std::string& name, const std::string& method, std::optional<double> limit,
                             std::string why) {
    return {name, method, {}, {}, limit, Decision::not_evaluable, std::move(why)};
}

Characteristic reported(const char* name, const std::string& method, double value, double u95, std::string note) {
    return {name, method, value, u95, {}, Decision::reported, std::move(note)};
}

std::optional<double> limit_of(const ProfileZone& zone, const EvaluationOptions& options) {
    return zone.edge ? options.edge_profile_mm : options.profile_mm;
}

/// Half the 95 % interval of a deviation that is the largest of a zone: found among as many places as there are
/// independent values of the noise, about one for three points, in each of four zones.
double u95_of_worst(const ContourPoint& worst, double u95_mm, const SectionResult& section) {
    constexpr double points_of_a_value = 12.0;
    const auto used = static_cast<double>(section.points.size() - section.rejected());
    const double k = std::max(2.0, fitting::coverage_95_of_largest(std::max(1.0, used / points_of_a_value)));
    return 0.5 * k * (u95_mm - worst.offset_error_mm) + worst.offset_error_mm;
}

/// What lies between the largest deviation of a zone and the largest that its places may have, and have for certain.
/// All of them share the risk (Sidak 1967), three times as many as the zone has points: the largest of a smooth random
/// curve is that of fewer independent values, and the rest is for the places beside an edge, where the curvature jumps
/// and the curve is farther off than the noise says (docs/theory.md).
class ZoneGuards {
  public:
    ZoneGuards(const DecisionRule& rule, double coverage, double points)
        : coverage_(coverage),
          deviate_(fitting::upper_deviate_of_largest(rule.risk_of_look(), std::max(1.0, points))) {}

    void add(const ContourPoint& place, double u95_mm, double deviation_mm) {
        const double size = std::abs(deviation_mm), bound = place.offset_error_mm + place.bound_mm;
        const double sigma = std::max(0.0, u95_mm - bound) / coverage_;
        largest_ = std::max(largest_, size);
        at_most_ = std::max(at_most_, size + deviate_ * sigma + bound);
        at_least_ = std::max(at_least_, size - deviate_ * sigma - bound);
    }
    /// Of the width 2 max|d|.
    GuardBands of_width() const { return {2.0 * (at_most_ - largest_), 2.0 * (largest_ - at_least_)}; }

  private:
    double coverage_, deviate_;
    double largest_ = 0.0, at_most_ = 0.0, at_least_ = std::numeric_limits<double>::lowest();
};

std::string profile_method_of(const fitting::FilterSpec& filter, const std::string& frame) {
    static constexpr std::array<std::pair<fitting::FilterKind, const char*>, 3> names{
        {{fitting::FilterKind::gaussian, "Gaussian filter ISO 16610-21"},
         {fitting::FilterKind::spline, "spline filter ISO 16610-22"},
         {fitting::FilterKind::robust_gaussian, "robust Gaussian filter ISO 16610-31"}}};
    for (const auto& [kind, name] : names)
        if (kind == filter.kind)
            return profile_method + frame + ", " + name + ", cut-off " + core::fixed(filter.cutoff_mm, 3) + " mm";
    return profile_method + frame;
}

std::string worst_note(double deviation_mm, const Vector2d& at) {
    return "worst d " + std::string(deviation_mm > 0 ? "+" : "") + core::length_text(deviation_mm) + " at x " +
           core::fixed(at.x(), 3) + " mm, y " + core::fixed(at.y(), 3) + " mm";
}

/// Deviations of a contour in a frame, filtered, a value for each of its points. A filter takes noise away; the
/// uncertainty stays that of the contour and of the alignment.
struct Compared {
    const std::vector<ContourPoint>& contour;
    const fitting::FilteredZones& deviation;
    const Alignment& alignment;
    std::string frame;
};

Characteristic profile(const ProfileZone& zone, const SectionResult& section, const Compared& compared,
                       const EvaluationOptions& options) {
    const auto& contour = compared.contour;
    const auto& deviation = compared.deviation;
    const auto limit = limit_of(zone, options);
    const std::string method = profile_method_of(options.filters.at(zone.zone), compared.frame);
    std::optional<std::size_t> worst;
    std::size_t points = 0;
    std::size_t judged = 0;
    const auto in_zone = std::count_if(contour.begin(), contour.end(),
                                       [&](const ContourPoint& point) { return point.zone == zone.zone; });
    const double used = static_cast<double>(section.points.size() - section.rejected());
    ZoneGuards guards(options.rule, section.fit->contour_noise.coverage(),
                      places_of_a_point * used * static_cast<double>(in_zone) / static_cast<double>(contour.size()));
    for (std::size_t i = 0; i < contour.size(); ++i) {
        if (contour[i].zone != zone.zone) continue;
        ++points;
        if (!deviation.values[i]) continue;
        ++judged;
        guards.add(contour[i], aligned_u95_mm(contour[i], compared.alignment), *deviation.values[i]);
        if (!worst || std::abs(*deviation.values[i]) > std::abs(*deviation.values[*worst])) worst = i;
    }
    if (points == 0) return not_evaluable(zone.name, method, limit, "the contour has no such zone");
    if (const auto& why = deviation.refused[static_cast<std::size_t>(zone.zone)]; !why.empty())
        return not_evaluable(zone.name, method, limit, why);
    if (!worst) return not_evaluable(zone.name, method, limit, not_reached);
    const double largest = *deviation.values[*worst];
    const double u95_mm = u95_of_worst(contour[*worst], aligned_u95_mm(contour[*worst], compared.alignment), section);
    Characteristic c{zone.name, method, 2.0 * std::abs(largest), 2.0 * u95_mm, limit, Decision::reported, {}};
    c.note = worst_note(largest, contour[*worst].position_mm);
    if (const auto note = offset_error_note(contour[*worst].offset_error_mm, Unit::mm); !note.empty())
        c.note += "; " + note;
    if (const auto share = static_cast<double>(points - judged) / static_cast<double>(points); share > shown_share)
        c.note += "; " + core::fixed(100.0 * share, 1) + " % of it " + not_reached;
    const auto [accept, reject] = guards.of_width();
    c.guard_accept = accept;
    c.guard_reject = reject;
    decide(c, options.rule);
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

Characteristic edge_radius(const char* name, const fitting::EdgeFit& edge, std::optional<fitting::EdgeModel> asked,
                           double error) {
    const std::string method = radius_method_of(edge.model);
    if (!edge.valid) return not_evaluable(name, method, {}, edge.why.empty() ? "no circular edge" : edge.why);
    if (asked && edge.model != *asked)
        return not_evaluable(name, method, {},
                             "the points do not tell the form that was asked for; they give " +
                                 core::fixed(edge.radius_mm, 4) + " mm by another");
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

/// The chord and the thickness without a camber line: as the edges and the contour's points say, with bounds of their
/// uncertainties.
Characteristic plain_chord(const fitting::SectionFit& fit, const std::string& why) {
    const auto& le = nearest_to(fit.contour, fit.le_point_mm);
    const auto& te = nearest_to(fit.contour, fit.te_point_mm);
    auto c = reported("chord", "NOSETAIL: between the points where the edges halve the turn of the sides", fit.chord_mm,
                      size_u95(le, te), offset_error_note(le.offset_error_mm + te.offset_error_mm, Unit::mm));
    c.note += (c.note.empty() ? "" : "; ") + why;
    return c;
}

Characteristic plain_thickness(const fitting::SectionFit& fit, const std::string& why) {
    const auto& worst = *std::max_element(fit.contour.begin(), fit.contour.end(), [](const auto& a, const auto& b) {
        const auto of_side = [](const ContourPoint& p) {
            return p.zone == Zone::suction || p.zone == Zone::pressure ? p.u95_mm : -1.0;
        };
        return of_side(a) < of_side(b);
    });
    auto c = reported("max_thickness", thickness_method, fit.max_thickness_mm, size_u95(worst, worst),
                      offset_error_note(2.0 * worst.offset_error_mm, Unit::mm));
    c.note += (c.note.empty() ? "" : "; ") + why;
    return c;
}

Characteristic size_of(const char* name, const fitting::Measure& measure, const fitting::MeasuredSection& measured) {
    const auto uncertainty = measured.uncertainty(measure);
    return reported(name, std::string(measure.method), measure.value, uncertainty.u95,
                    offset_error_note(uncertainty.offset_error, Unit::mm));
}

void add_sizes(SectionResult& section, fitting::MeasuredSection& measured, const EvaluationOptions& options) {
    const auto& fit = *section.fit;
    auto& out = section.characteristics;
    out.push_back(
        edge_radius("le_radius", fit.le, options.le_model, nearest_to(fit.contour, fit.le_point_mm).offset_error_mm));
    out.push_back(
        edge_radius("te_radius", fit.te, options.te_model, nearest_to(fit.contour, fit.te_point_mm).offset_error_mm));
    const auto chord = fitting::measure_chord(measured, fitting::ChordMethod::nose_tail);
    out.push_back(chord ? size_of("chord", *chord, measured) : plain_chord(fit, chord.error().message));
    const auto thickness = fitting::measure_max_thickness(measured);
    out.push_back(thickness ? size_of("max_thickness", *thickness, measured)
                            : plain_thickness(fit, thickness.error().message));
}

/// The profiles after the best fit: the contour is carried into the frame of the nominal, once for all zones.
class FormProfiles {
  public:
    /// `contour`: of which the best fit is.
    FormProfiles(const SectionResult& section, const std::vector<ContourPoint>& contour,
                 const ReferenceContour* nominal, const EvaluationOptions& options)
        : section_(section), contour_(contour), nominal_(nominal) {
        unlimited_.filters = options.filters;
        unlimited_.rule = options.rule;
    }

    Characteristic of(CharacteristicKind kind, const fitting::BestFit& fit) {
        if (moved_.empty()) compare(fit);
        constexpr std::array zones{Zone::le, Zone::suction, Zone::te, Zone::pressure};
        const auto first = static_cast<std::size_t>(CharacteristicKind::profile_form_le);
        const Zone zone = zones[static_cast<std::size_t>(kind) - first];
        const auto& of_zone = *std::find_if(profile_zones.begin(), profile_zones.end(),
                                            [&](const ProfileZone& z) { return z.zone == zone; });
        return profile(of_zone, section_, {moved_, filtered_, unaligned_, "after the best fit of the section"},
                       unlimited_);
    }

  private:
    void compare(const fitting::BestFit& fit) {
        moved_ = contour_;
        for (auto& point : moved_) {
            point.position_mm = fit.motion.undo(point.position_mm);
            point.normal = fit.motion.undo_on_direction(point.normal);
        }
        auto compared = moved_;  // takes the offset error of the nominal's lean, which the contour has already
        filtered_ = fitting::filter_zones(moved_, nominal_->compare(compared), unlimited_.filters);
    }

    const SectionResult& section_;
    const std::vector<ContourPoint>& contour_;
    const ReferenceContour* nominal_;
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
    FormProfiles forms(section, measured.fit().contour, nominal, options);
    const auto form = [&](CharacteristicKind kind, const fitting::BestFit& fit) { return forms.of(kind, fit); };
    AskedCharacteristics asked(measured, section.deviation_mm, nominal != nullptr ? curve : nullptr, form, options.rule,
                               datum);
    for (const auto& spec : options.asked) {
        if (!is_of_part(spec.kind)) {
            if (spec.is_of(section.index)) replace_or_add(asked.make(spec, section), section);
        } else if (spec.kind != CharacteristicKind::generatrix) {
            if (!section.placement) section.placement = asked.placement();
        } else if (nominal != nullptr && section.alignment.state != Alignment::State::refused) {
            if (auto point = span_point(*section.fit, *curve, section.alignment.motion, spec))
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

void add_profiles_not_evaluable(SectionResult& section, const EvaluationOptions& options, const std::string& why) {
    for (const auto& zone : profile_zones) {
        const auto method = profile_method_of(options.filters.at(zone.zone), frame_words(options.alignment));
        section.characteristics.push_back(not_evaluable(zone.name, method, limit_of(zone, options), why));
    }
}

void add_nothing_evaluable(SectionResult& section, bool with_profiles, const EvaluationOptions& options) {
    auto& out = section.characteristics;
    if (with_profiles) add_profiles_not_evaluable(section, options, section.why);
    out.push_back(not_evaluable("le_radius", radius_method, {}, section.why));
    out.push_back(not_evaluable("te_radius", radius_method, {}, section.why));
    out.push_back(not_evaluable("chord", chord_method, {}, section.why));
    out.push_back(not_evaluable("max_thickness", thickness_method, {}, section.why));
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
    if (!section.closed()) section.why = "the section is not closed";
}

/// Finds the alignment where it is the section's own matter, and takes the deviations after it.
void compare_with(const ReferenceContour& nominal, const fitting::NominalSection* curve,
                  const EvaluationOptions& options, const SectionAlignment* shared, SectionResult& section) {
    auto& contour = section.fit->contour;
    if (options.alignment.kind == AlignmentKind::none) {
        section.deviation_mm = nominal.compare(contour);
        return;
    }
    if (shared != nullptr) {
        section.alignment = shared->alignment;
        if (!section.alignment.done()) return;
    } else {
        const auto own = align_section(*section.fit, nominal, curve->curve(), options.alignment,
                                       {options.profile_mm, options.edge_profile_mm});
        if (!own) {
            section.alignment.state = Alignment::State::refused;
            section.alignment.spec = options.alignment;
            section.alignment.note = own.error().message;
            return;
        }
        section.alignment = own->alignment;
        if (options.alignment.kind == AlignmentKind::blade) {
            section.alignment.state = Alignment::State::provisional;
            section.alignment.note = "by this section alone";
        }
    }
    const auto& motion = section.alignment.motion;
    section.deviation_mm = compare_aligned(contour, nominal, motion);
    for (auto& point : section.nominal_contour)
        point = motion.apply(point);
}

void add_profiles(SectionResult& section, const EvaluationOptions& options) {
    if (section.alignment.state == Alignment::State::refused)
        return add_profiles_not_evaluable(section, options, section.alignment.note);
    const std::string frame = frame_words(options.alignment);
    const auto& contour = section.fit->contour;
    const auto filtered = fitting::filter_zones(contour, section.deviation_mm, options.filters);
    for (const auto& zone : profile_zones)
        section.characteristics.push_back(
            profile(zone, section, {contour, filtered, section.alignment, frame}, options));
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
    const auto deviation = compare_aligned(contour, nominal, aligned->alignment.motion);
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
    std::vector<std::string_view> names;
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

std::string offset_error_note(double error, Unit unit) {
    if (!(error > 0.0)) return {};
    const std::string size = unit == Unit::mm ? core::length_text(error) : worded(error, unit);
    return "U95 includes " + size + " of 2-D offset error";
}

void decide(Characteristic& c, const DecisionRule& rule) {
    if (!c.has_limits() || !c.value || !c.u95) return;
    if (!c.guard_accept || !c.guard_reject) {
        const auto [accept, reject] = rule.guards(*c.u95);
        c.guard_accept = accept;
        c.guard_reject = reject;
    }
    c.decision = rule.decide(*c.value, {*c.guard_accept, *c.guard_reject}, c.lower, c.upper);
}

SectionResult evaluate_section(SectionResult section, core::Result<fitting::SectionFit> fit,
                               const ReferenceContour* nominal, const EvaluationOptions& options,
                               const fitting::NominalSection* curve, const SectionAlignment* shared) {
    section.characteristics.clear();
    section.deviation_mm.clear();
    section.alignment = {};
    section.placement.reset();
    section.span_points.clear();
    take_fit(section, std::move(fit));
    if (nominal != nullptr) section.nominal_contour = nominal->points();
    if (!section.why.empty()) {
        add_nothing_evaluable(section, nominal != nullptr, options);
        return section;
    }
    if (nominal != nullptr) {
        compare_with(*nominal, curve, options, shared, section);
        add_profiles(section, options);
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
