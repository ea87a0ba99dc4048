// SPDX-License-Identifier: Apache-2.0
#include "acquisition/point_tolerance.hpp"

#include <algorithm>

#include "acquisition/characteristic.hpp"
#include "acquisition/worst_place.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

std::string tolerance_method(const std::string& frame) {
    return "POINTTOL: largest excess over the tolerances of the nominal's points, " + frame;
}

double excess_of(double deviation_mm, const PointTolerance& limits) {
    return std::max(deviation_mm - limits.above_mm, limits.below_mm - deviation_mm);
}

std::string limits_note(const PointTolerance& limits) {
    return "limits there " + core::length_text(limits.below_mm) + " to " + (limits.above_mm > 0.0 ? "+" : "") +
           core::length_text(limits.above_mm);
}

}  // namespace

std::vector<PointTolerance> tolerances_along(const SectionResult& section, const ReferenceContour& nominal) {
    const auto& motion = section.alignment.motion;
    std::vector<PointTolerance> out;
    std::optional<double> near_mm;
    for (const auto& point : section.fit->contour) {
        const auto foot =
            nominal.compare(motion.undo(point.position_mm), motion.undo_on_direction(point.normal), near_mm);
        near_mm = foot.s_mm;
        out.push_back(nominal.tolerance_at(foot.s_mm));
    }
    return out;
}

Characteristic point_tolerance(const SectionResult& section, const Compared& compared,
                               const EvaluationOptions& options) {
    const auto& contour = compared.contour;
    const auto& deviation = compared.deviation;
    for (const auto& why : deviation.refused)
        if (!why.empty()) return point_tolerance_not_evaluable(options, why);
    WorstPlace places(options.rule, section, contour.size());
    std::optional<std::size_t> worst;
    double largest = 0.0;
    PointTolerance limits_there;
    std::size_t unmeasured = 0;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        unmeasured += contour[i].measured ? 0 : 1;
        if (!deviation.values[i]) continue;
        const PointTolerance& limits = section.tolerances[i];
        const double excess = excess_of(*deviation.values[i], limits);
        places.add(contour[i], scatter_u95_mm(contour[i], compared.alignment), excess);
        if (worst && excess <= largest) continue;
        worst = i;
        largest = excess;
        limits_there = limits;
    }
    if (!worst) return point_tolerance_not_evaluable(options, "the ball reaches no place of it");
    const auto& at = contour[*worst];
    const double scatter_mm = scatter_u95_mm(at, compared.alignment);
    Characteristic c{point_tolerance_name,
                     tolerance_method(compared.frame),
                     largest,
                     u95_of_worst(at, scatter_mm, section),
                     0.0,
                     Decision::reported,
                     worst_note(*deviation.values[*worst], at.position_mm) + ", " + limits_note(limits_there)};
    if (const auto note = offset_error_note(at.offset_error_mm, Unit::mm); !note.empty()) c.note += "; " + note;
    const auto& noise = section.fit->contour_noise;
    if (noise.has_fields()) c.budget = budget_at(at, scatter_mm, noise.coverage());
    const auto [accept, reject] = places.guards();
    c.guard_accept = accept;
    c.guard_reject = reject;
    know_gap(static_cast<double>(unmeasured) / static_cast<double>(contour.size()), c);
    decide(c, options.rule);
    return c;
}

Characteristic point_tolerance_not_evaluable(const EvaluationOptions& options, const std::string& why) {
    return not_evaluable(point_tolerance_name, tolerance_method(frame_words(options.alignment)), 0.0, why);
}

}  // namespace cmm::acquisition
