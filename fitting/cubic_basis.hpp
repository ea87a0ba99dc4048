// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// The four cubic B-splines that live on a knot span [t_k, t_{k+1}], as polynomials of w = (t - t_k) / (t_{k+1} - t_k):
/// function a is the sum of power[p][a] w^p, and belongs to the control point whose support begins at t_{k-3+a}.
struct CubicBasis {
    std::array<std::array<double, 4>, 4> power;

    std::array<double, 4> at(double w) const {
        std::array<double, 4> b;
        for (std::size_t a = 0; a < 4; ++a)
            b[a] = power[0][a] + w * (power[1][a] + w * (power[2][a] + w * power[3][a]));
        return b;
    }
};

/// From the six knots t_{k-2} ... t_{k+3} (repeated ones allowed, t_k < t_{k+1}): the matrix form of the recursion of
/// seed 000, eq 7 (Qin 2000, General matrix representations for B-splines).
inline CubicBasis cubic_basis(const double* knots) {
    const double low = knots[2], high = knots[3], h = high - low;
    const double left = low - knots[1], right = knots[4] - low;
    const double wide = 1.0 / (knots[4] - knots[1]);  // t_{k+2} - t_{k-1}
    const double from_left = 1.0 / (high - knots[1]), from_right = 1.0 / right;
    const double first = h * h * from_left / (high - knots[0]);
    const double last = h * h * from_right / (knots[5] - low);
    const double before = left * left * wide * from_left, slope = 3.0 * h * left * wide * from_left;
    const double bend = 3.0 * h * h * wide * from_left;
    const double cubic = -bend / 3.0 - last - h * h * from_right * wide;
    return {{{{1.0 * first, 1.0 - first - before, before, 0.0},
              {-3.0 * first, 3.0 * first - slope, slope, 0.0},
              {3.0 * first, -3.0 * first - bend, bend, 0.0},
              {-first, first - cubic - last, cubic, last}}}};
}

/// The span's polynomial a + b u + c u^2 + d u^3, u = t - t_k; control(a) weighs function a.
template <class Control>
std::array<Vec2, 4> cubic_piece(const CubicBasis& basis, double width, const Control& control) {
    std::array<Vec2, 4> piece;
    double scale = 1.0;
    for (std::size_t p = 0; p < 4; ++p, scale /= width) {
        piece[p] = Vec2::Zero();
        for (std::size_t a = 0; a < 4; ++a)
            piece[p] += scale * basis.power[p][a] * control(a);
    }
    return piece;
}

}  // namespace cmm::fitting
