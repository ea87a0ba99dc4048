// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "core/error.hpp"
#include "fitting/open_edges.hpp"
#include "fitting/section.hpp"
#include "fitting/smoothing.hpp"

namespace cmm::fitting {

/// What the surface of ball centres said at a place of the curve of ball centres, which was moved by it.
struct SurfaceStation {
    double t = 0.0;  ///< parameter of the curve
    double lean_rad = 0.0;
    double noise_share = 1.0;  ///< of the curve's noise, that is left after the movement; 1: others took none
    double scatter_share = 1.0, kept_share = 1.0;  ///< the same, of CurveNoise::Variance's parts
    double lean_doubt_mm = 0.0;                    ///< largest error by what is not known of the lean; added
    double drawn_doubt_mm = 0.0;                   ///< the same, with its sign, where it is as much chance as noise
    double offset_error_mm = 0.0;                  ///< of the 2-D offset by this lean
    bool moved = true;                             ///< false: the curve was left there as it is, or hardly moved

    /// The errors by the lean and by a doubt in it (infinite: nothing is known of that, and the error of the 2-D offset
    /// stands for it).
    void doubt(double ball_radius_mm, double lean_error_rad);
};

/// From the fitted curve of ball centres to the part: edge models that the contour takes, joins, offset, zones,
/// sampling, chord; fills these fields of `fit`, whose noise is known already. What is left to do, for
/// `fit_open_edges`, is returned. `good` are the points that `smooth` was fitted to. `surface`: none, or by ascending t
/// over the period. Errors: fit_not_evaluable (no two edges, ball too large).
core::Result<OpenEdges> build_contour(const SmoothCurve& smooth, std::span<const Vec2> good,
                                      const SectionOptions& options, SectionFit& fit,
                                      std::span<const SurfaceStation> surface = {});

}  // namespace cmm::fitting
