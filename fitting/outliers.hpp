// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Adjacent points: so many may be bad together; a longer run is a feature of the part.
inline constexpr std::size_t longest_bad_run = 5;

/// What the bad-point search found, per point of the chain.
struct BadPoints {
    std::vector<char> bad;
    std::vector<char> corner;          ///< good points next to a corner: only one of their sides predicts them
    std::vector<double> residual;      ///< from the good neighbours; positive on the right-hand side of the travel
    std::vector<double> threshold_mm;  ///< of that residual: the factor times its own standard deviation
    double sigma_mm = 0.0;             ///< standard deviation of a point, from the residuals of the whole chain
    std::size_t count = 0;
};

/// The four-neighbour test (seed 000, A8) finds where something is wrong; there all points are set aside and come back
/// as long as the good ones around them predict them, so that runs of up to five bad points cannot excuse each other
/// (docs/theory.md, section 2). Nothing below `floor_mm` is called bad. Closed chains wrap. O(n); never throws.
BadPoints find_bad_points(std::span<const Vec2> points, bool closed, double floor_mm);

/// The first half of it, for who only asks for the way: the points that the good ones around them contradict sharply,
/// worst first. Where neighbours disagree with each other nobody is called bad. O(n); never throws.
std::vector<char> find_clearly_bad_points(std::span<const Vec2> points, bool closed, double floor_mm);

}  // namespace cmm::fitting
