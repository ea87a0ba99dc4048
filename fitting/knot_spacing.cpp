// SPDX-License-Identifier: Apache-2.0
#include "fitting/knot_spacing.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr double growth = 2.5;               // of the spacing a millimetre of curve, times the turning of a span
constexpr double widest_share = 1.0 / 60.0;  // of the period
constexpr std::size_t least_graded_spans = 24;
constexpr std::size_t anchor_reach = 4;  // anchors to either side that show the turn

constexpr double least_length = 1e-300;
constexpr double usual_sigma_mm = 1e-3;
constexpr double finest = 0.25, coarsest = 1.2;

}  // namespace

double span_turn(double sigma_mm) {
    return usual_turn_rad * std::clamp(std::cbrt(sigma_mm / usual_sigma_mm), finest, coarsest);
}

std::vector<double> graded_knots(std::span<const Vec2> anchors, std::span<const double> t, double period,
                                 double turn_rad, std::size_t most, std::span<const double> widest) {
    const std::size_t n = anchors.size(), w = std::clamp<std::size_t>(n / 12, 1, anchor_reach);
    const double grading = growth * turn_rad;
    const auto step = [&](std::size_t i) { return i + 1 < n ? t[i + 1] - t[i] : t[0] + period - t[i]; };
    std::vector<double> spacing(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 in = anchors[i] - anchors[i >= w ? i - w : i + n - w];
        const Vec2 out = anchors[i + w < n ? i + w : i + w - n] - anchors[i];
        const double before = in.norm(), behind = out.norm();
        const double turn = turn_between(in / std::max(before, least_length), out / std::max(behind, least_length));
        const double curvature = std::abs(turn) / std::max(0.5 * (before + behind), least_length);
        spacing[i] = std::min(turn_rad / std::max(curvature, 1e-12), widest_share * period);
        if (!widest.empty()) spacing[i] = std::min(spacing[i], widest[i]);
    }
    const auto next = [n](std::size_t i) { return i + 1 < n ? i + 1 : 0; };
    for (int round = 0; round < 2; ++round)
        for (std::size_t i = 0; i < n; ++i)
            spacing[next(i)] = std::min(spacing[next(i)], spacing[i] + grading * step(i));
    for (int round = 0; round < 2; ++round)
        for (std::size_t i = n; i-- > 0;)
            spacing[i] = std::min(spacing[i], spacing[next(i)] + grading * step(i));
    std::vector<double> spans(n + 1, 0.0);  // how many spans lie before each anchor
    for (std::size_t i = 0; i < n; ++i)
        spans[i + 1] = spans[i] + 0.5 * step(i) * (1.0 / spacing[i] + 1.0 / spacing[next(i)]);
    const double wanted = std::clamp(std::ceil(spans[n]), static_cast<double>(std::min(least_graded_spans, most)),
                                     static_cast<double>(most));
    const auto count = static_cast<std::size_t>(wanted);
    std::vector<double> breaks(count + 1);
    std::size_t i = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double target = spans[n] * static_cast<double>(k) / wanted;
        while (i + 1 < n && spans[i + 1] <= target)
            ++i;
        breaks[k] = t[i] + step(i) * (target - spans[i]) / (spans[i + 1] - spans[i]);
    }
    breaks[count] = t[0] + period;
    return breaks;
}

}  // namespace cmm::fitting
