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
        const Vec2 in = anchors[i] - anchors[(i + n - w) % n], out = anchors[(i + w) % n] - anchors[i];
        const double curvature = std::abs(turn_angle(in, out)) / (0.5 * (in.norm() + out.norm()));
        spacing[i] = std::min(turn_rad / std::max(curvature, 1e-12), widest_share * period);
        if (!widest.empty()) spacing[i] = std::min(spacing[i], widest[i]);
    }
    for (std::size_t i = 0; i < 2 * n; ++i)
        spacing[(i + 1) % n] = std::min(spacing[(i + 1) % n], spacing[i % n] + grading * step(i % n));
    for (std::size_t i = 2 * n; i-- > 0;)
        spacing[i % n] = std::min(spacing[i % n], spacing[(i + 1) % n] + grading * step(i % n));
    std::vector<double> spans(n + 1, 0.0);  // how many spans lie before each anchor
    for (std::size_t i = 0; i < n; ++i)
        spans[i + 1] = spans[i] + 0.5 * step(i) * (1.0 / spacing[i] + 1.0 / spacing[(i + 1) % n]);
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
