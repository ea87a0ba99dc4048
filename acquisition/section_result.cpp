// SPDX-License-Identifier: Apache-2.0
#include "acquisition/section_result.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/text.hpp"
#include "core/units.hpp"
#include "fitting/datum.hpp"

namespace cmm::acquisition {
namespace {

constexpr int z_digits = 1;

std::string where(const SectionResult& section) {
    return "section " + std::to_string(section.index) + " (z " + core::fixed(section.z_mm, z_digits) + ")";
}

bool needs_a_number(const Characteristic& c) {
    return c.decision == Decision::not_evaluable || !c.value || !c.has_limits();
}

double beyond(const Characteristic& c, double limit) {
    return c.lower && limit == *c.lower ? limit - *c.value : *c.value - limit;
}

/// The limit that the value is nearer to, or farther beyond.
double nearer_limit(const Characteristic& c) {
    if (!c.lower || !c.upper) return c.upper ? *c.upper : *c.lower;
    return beyond(c, *c.lower) > beyond(c, *c.upper) ? *c.lower : *c.upper;
}

std::string cause(const Characteristic& c) {
    if (needs_a_number(c)) return " not evaluable: " + c.note;
    if (c.partly && c.decision != Decision::reject)
        return " " + worded(*c.value, c.unit) + " where it was measured, but part of it was not";
    const double limit = nearer_limit(c);
    const std::string relation = c.decision == Decision::reject
                                     ? (c.lower && limit == *c.lower ? " < " : " > ") + worded(limit, c.unit)
                                     : " is too near to " + worded(limit, c.unit) + " to decide";
    return " " + worded(*c.value, c.unit) + " +- " + worded(c.u95.value_or(0.0), c.unit) + relation;
}

/// By what they exceed their limits; those without a number last.
bool worse(const Characteristic* a, const Characteristic* b) {
    const auto excess = [](const Characteristic& c) {
        return needs_a_number(c) ? std::numeric_limits<double>::lowest() : beyond(c, nearer_limit(c));
    };
    return excess(*a) > excess(*b);
}

/// One line for all characteristics of one decision: the worst in full, the others by name and value.
std::string causes(std::vector<const Characteristic*> all) {
    std::stable_sort(all.begin(), all.end(), worse);
    const Characteristic& worst = *all.front();
    const auto told_with_it = [&](const Characteristic* c) {
        return needs_a_number(worst) && needs_a_number(*c) && c->note == worst.note;
    };
    std::string names = worst.name;
    std::string also;
    for (const auto* c : std::span(all).subspan(1)) {
        if (told_with_it(c)) {
            names += ", " + c->name;
        } else {
            also += (also.empty() ? "; also " : ", ") + c->name + " " +
                    (needs_a_number(*c) ? "(" + c->note + ")" : worded(*c->value, c->unit));
        }
    }
    return names + cause(worst) + also;
}

struct NotAccepted {
    std::vector<const Characteristic*> rejected, open;
};
NotAccepted not_accepted(std::span<const Characteristic> all) {
    NotAccepted out;
    for (const auto& c : all) {
        if (c.decision == Decision::reject) {
            out.rejected.push_back(&c);
        } else if (c.has_requirement() && c.decision != Decision::accept && c.decision != Decision::reported) {
            out.open.push_back(&c);
        }
    }
    return out;
}

std::string gaps_text(const SectionResult& section) {
    return core::length_text(section.missing_mm()) + " of it were not measured";
}

/// Why a section is rejected, or else why it is open; empty when it is neither.
std::string reason(const SectionResult& section) {
    const auto [rejected, open] = not_accepted(section.characteristics);
    const std::string out = rejected.empty() ? "" : causes(rejected);
    if (section.has_contour() && rejected.empty())
        return !open.empty() ? causes(open) : section.decision() == Decision::undecided ? gaps_text(section) : out;
    if (section.has_contour()) return out;
    return out + (out.empty() ? "" : "; ") + (section.why.empty() ? "not closed" : section.why);
}

}  // namespace

std::string_view to_string(Decision decision) noexcept {
    switch (decision) {
        case Decision::accept:
            return "accept";
        case Decision::reject:
            return "reject";
        case Decision::undecided:
            return "undecided";
        case Decision::reported:
            return "reported";
        case Decision::not_evaluable:
            return "not_evaluable";
    }
    return "not_evaluable";
}

std::string_view to_string(Compensation::State state) noexcept {
    switch (state) {
        case Compensation::State::flat:
            return "2d";
        case Compensation::State::provisional:
            return "provisional";
        case Compensation::State::final:
            return "final";
    }
    return "2d";
}

std::size_t SectionResult::rejected() const {
    return static_cast<std::size_t>(std::count_if(points.begin(), points.end(), [](const RecordedPoint& point) {
        return point.verdict.reason != fitting::RejectReason::none;
    }));
}

std::size_t SectionResult::not_reached() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < deviation_mm.size(); ++i)
        count += !deviation_mm[i] && fit->contour[i].measured ? 1 : 0;
    return count;
}

std::string SectionResult::why_not_all_round() const {
    return has_contour() ? fit->missing : why;
}

std::optional<Eigen::Vector2d> SectionResult::nose_mm(fitting::Zone edge) const {
    if (!has_contour()) return std::nullopt;
    const Eigen::Vector2d& nose = edge == fitting::Zone::le ? fit->le_point_mm : fit->te_point_mm;
    return nearest_to(fit->contour, nose).measured ? std::optional(nose) : std::nullopt;
}

std::vector<ContourGap> SectionResult::gaps() const {
    std::vector<ContourGap> out;
    if (!fit) return out;
    const auto& contour = fit->contour;
    const std::size_t n = contour.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (!contour[i].measured || contour[(i + 1) % n].measured) continue;
        ContourGap gap{i, i, 0.0};
        do {
            const std::size_t next = (gap.behind + 1) % n;
            gap.length_mm += (contour[next].position_mm - contour[gap.behind].position_mm).norm();
            gap.behind = next;
        } while (!contour[gap.behind].measured);
        out.push_back(gap);
    }
    return out;
}

double SectionResult::missing_mm() const {
    double length_mm = 0.0;
    for (const ContourGap& gap : gaps())
        length_mm += gap.length_mm;
    return length_mm;
}

double SectionResult::deviation_u95_mm(std::size_t point) const {
    return aligned_u95_mm(fit->contour[point], alignment);
}

double scatter_u95_mm(const fitting::ContourPoint& point, const Alignment& alignment) {
    constexpr double coverage = 2.0;
    if (!alignment.done()) return point.u95_mm;
    // Noise in quadrature; what is a bound is added.
    const double added = point.bound_mm + point.offset_error_mm;
    const double by_motion =
        coverage * fitting::normal_uncertainty(alignment.motion, alignment.covariance, point.position_mm, point.normal);
    return std::hypot(std::max(0.0, point.u95_mm - added), by_motion) + added;
}

const SectionPlacement* SectionResult::placement(const ZoneSet& zones) const {
    const auto found = std::find_if(placements.begin(), placements.end(),
                                    [&](const SectionPlacement& placed) { return placed.zones == zones; });
    return found == placements.end() ? nullptr : &*found;
}

double aligned_u95_mm(const fitting::ContourPoint& point, const Alignment& alignment) {
    constexpr double coverage = 2.0;
    const double u95_mm = scatter_u95_mm(point, alignment), shared = point.machine.shared_mm();
    if (shared == 0.0) return u95_mm + std::abs(point.machine.known_mm);
    const double added = point.bound_mm + point.offset_error_mm;
    return std::hypot(std::max(0.0, u95_mm - added), coverage * shared) + added + std::abs(point.machine.known_mm);
}

const Characteristic* SectionResult::find(std::string_view characteristic_name) const {
    const auto at = std::find_if(characteristics.begin(), characteristics.end(),
                                 [&](const Characteristic& c) { return c.name == characteristic_name; });
    return at == characteristics.end() ? nullptr : &*at;
}

Decision SectionResult::decision() const {
    const auto [rejected, open] = not_accepted(characteristics);
    if (!rejected.empty()) return Decision::reject;
    if (!open.empty() || !has_contour()) return Decision::undecided;
    const bool accepted = std::any_of(characteristics.begin(), characteristics.end(),
                                      [](const Characteristic& c) { return c.decision == Decision::accept; });
    if (accepted) return Decision::accept;
    return misses_little(*fit) ? Decision::reported : Decision::undecided;
}

const fitting::ContourPoint& nearest_to(const std::vector<fitting::ContourPoint>& contour,
                                        const Eigen::Vector2d& point_mm) {
    const auto nearer = [&](const fitting::ContourPoint& a, const fitting::ContourPoint& b) {
        return (a.position_mm - point_mm).squaredNorm() < (b.position_mm - point_mm).squaredNorm();
    };
    return *std::min_element(contour.begin(), contour.end(), nearer);
}

bool misses_little(const fitting::SectionFit& fit) {
    constexpr double most_missing_share = 0.05;
    double missing_mm = 0.0;
    for (std::size_t i = 1; i < fit.contour.size(); ++i) {
        const fitting::ContourPoint &from = fit.contour[i - 1], &to = fit.contour[i];
        if (!from.measured || !to.measured) missing_mm += to.arc_length_mm - from.arc_length_mm;
    }
    return missing_mm <= most_missing_share * fit.contour.back().arc_length_mm;
}

std::string section_text(std::size_t index, double z_mm) {
    return "section " + std::to_string(index) + " (z " + core::fixed(z_mm, 3) + " mm)";
}

std::string name_of(const PartCharacteristic& c) {
    return c.number.name + (c.section ? " of section " + std::to_string(*c.section) : std::string());
}

Decision PartResult::verdict() const {
    Decision worst = complete && !sections.empty() ? Decision::accept : Decision::undecided;
    for (const auto& section : sections) {
        const auto decision = section.decision();
        if (decision == Decision::reject) return Decision::reject;
        if (decision == Decision::undecided) worst = Decision::undecided;
    }
    for (const auto& [c, section] : characteristics) {
        if (c.decision == Decision::reject) return Decision::reject;
        if (c.has_requirement() && c.decision != Decision::accept) worst = Decision::undecided;
    }
    return worst;
}

const Alignment* PartResult::alignment() const {
    for (const auto& section : sections)
        if (section.alignment.state != Alignment::State::none) return &section.alignment;
    return nullptr;
}

bool PartResult::has_requirements() const {
    for (const auto& section : sections) {
        for (const auto& c : section.characteristics) {
            if (c.has_requirement()) return true;
        }
    }
    return std::any_of(characteristics.begin(), characteristics.end(),
                       [](const PartCharacteristic& c) { return c.number.has_requirement(); });
}

std::vector<Eigen::Vector2d> contour_positions(const SectionResult& section) {
    std::vector<Eigen::Vector2d> out;
    if (!section.has_contour()) return out;
    for (const auto& point : section.fit->contour)
        out.push_back(point.position_mm);
    return out;
}

std::map<int, std::size_t> points_of_passes(const SectionResult& section) {
    std::map<int, std::size_t> count;
    for (const auto& point : section.points)
        if (point.pass > 0) ++count[point.pass];
    return count;
}

std::vector<std::string> verdict_reasons(const PartResult& part) {
    std::vector<std::string> rejected;
    std::vector<std::string> open;
    for (const auto& section : part.sections) {
        const auto text = reason(section);
        if (text.empty()) continue;
        (section.decision() == Decision::reject ? rejected : open).push_back(where(section) + ": " + text);
    }
    std::vector<Characteristic> of_part;
    for (const auto& c : part.characteristics) {
        of_part.push_back(c.number);
        of_part.back().name = name_of(c);
    }
    const auto of_parts = not_accepted(of_part);
    if (!of_parts.rejected.empty()) rejected.push_back("part: " + causes(of_parts.rejected));
    if (of_parts.rejected.empty() && !of_parts.open.empty()) open.push_back("part: " + causes(of_parts.open));
    if (!part.complete) open.push_back("the measurement ended before all sections were measured");
    if (part.sections.empty()) open.push_back("no section was measured");
    rejected.insert(rejected.end(), open.begin(), open.end());
    return rejected;
}

}  // namespace cmm::acquisition
