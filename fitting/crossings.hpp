// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "fitting/parallel_curve.hpp"

namespace cmm::fitting {

/// Where a parallel curve meets itself: at x on one stretch and at x on a later one.
struct Crossing {
    std::size_t first = 0, second = 0;  ///< stretches, first <= second
    double first_x = 0.0, second_x = 0.0;
    Vec2 position = Vec2::Zero();
};

/// All crossings, to rounding. Pairs of stretches are ruled out by the boxes that hold them and by their turning: a
/// regular arc that turns by less than pi does not meet itself, nor do the two branches of a cusp. What is left is
/// halved until the two tangents' directions differ by more than both turn, so that they meet once at most, and
/// Newton's method finds where, or until they are apart. Branches that
/// only touch do not cross.
std::vector<Crossing> find_crossings(const ParallelCurve& curve);

}  // namespace cmm::fitting
