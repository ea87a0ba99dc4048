// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Good points on both sides of a gap in a chain, nearest to the gap first.
struct Neighbours {
    static constexpr std::size_t most = 8;  ///< a side
    std::array<Vec2, most> before, after;
    std::size_t count_before = 0, count_after = 0;
};

/// What the neighbours say about a point in the gap between them.
struct Verdict {
    double residual_mm = 0.0;  ///< from the prediction; positive on the right-hand side of the travel
    double sd_mm = 0.0;        ///< of the residual of a good point: noise, noise of the prediction, error of the model
    bool resolved = false;     ///< false: the neighbours are on no smooth curve, there is no prediction
    bool sharp = false;        ///< both sides together predict the point, about as well as can be
    bool corner = false;       ///< the two sides are not one smooth curve; the side that the point continues judged it

    double ratio() const { return sd_mm > 0.0 ? residual_mm / sd_mm : 0.0; }
};

/// Predicts `p` by a polynomial of least squares through the neighbours (Forsythe 1957), in coordinates along and
/// across the circle through three of them, so that edges of any radius are nearly straight. The degree is the lowest
/// that leaves residuals like noise of standard deviation `sigma_mm` > 0; what the next two degrees would change counts
/// as error of the model. When no smooth curve joins the two sides, the side that `p` continues better decides.
Verdict judge_point(const Neighbours& neighbours, const Vec2& p, double sigma_mm);

/// Predicts `p` in the same way by the points of one side alone, at most 16, nearest first.
Verdict judge_beyond(std::span<const Vec2> side, const Vec2& p, double sigma_mm);

}  // namespace cmm::fitting
