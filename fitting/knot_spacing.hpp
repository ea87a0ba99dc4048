// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// What a span of a smoothing spline holds at a noise of 1 um.
inline constexpr double usual_turn_rad = 0.1;
/// The same at another noise: less where there is less to lose in it.
double span_turn(double sigma_mm);
/// That a smoothing spline has at most.
inline constexpr std::size_t most_spans = 512;

/// Knots for a closed curve through `anchors` (noise far below their distance) at ascending parameters `t` in
/// [t_0, t_0 + period): no span turns by more than about `turn_rad`, none is longer than a sixtieth of the period, and
/// neighbouring spans differ in length by 2.5 turn_rad at most (0.1 rad: a quarter), so that a curvature that jumps is
/// followed from both sides, the closer the less a span turns. Nor is one longer than `widest` of the anchors in it
/// (empty: anything). At most `most` spans (then all are longer in proportion). Returns the breaks: spans + 1
/// parameters, the last one is t_0 + period.
std::vector<double> graded_knots(std::span<const Vec2> anchors, std::span<const double> t, double period,
                                 double turn_rad, std::size_t most, std::span<const double> widest = {});

}  // namespace cmm::fitting
