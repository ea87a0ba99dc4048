// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "core/error.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

struct Fairing {
    PiecewiseCubic curve;
    double largest_mm = 0.0;  ///< no point of the curve moved farther
    std::size_t moves = 0;
    double before = 0.0, after = 0.0;  ///< sum of the jumps of the third derivative at the knots, by the parameter
};

/// Fairs a closed cubic curve by removing and reinserting knots: the control at the knot with the largest jump of the
/// third derivative is put where the knot could be removed (Farin, Rein, Sapidis and Worsey 1987), when that lowers the
/// sum of all jumps; again and again, until no move lowers it (after Poliakoff, Wong and Thomas 1999, seed 000, A20).
/// No control leaves the ball of `most_mm` about its first place, so that the curve stays as near to itself, too. It
/// takes real form away together with noise: off in tolerance decisions unless asked for. Errors: fit_not_evaluable
/// (not a closed curve that is C2 at simple knots, most_mm negative).
core::Result<Fairing> fair_closed(const PiecewiseCubic& curve, double most_mm);

}  // namespace cmm::fitting
