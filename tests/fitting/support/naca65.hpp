// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace cmm::fitting::naca65 {

struct OutlinePoint {
    Eigen::Vector2d position, normal;  ///< unit, outward
    int part = 0;                      ///< lower side, TE, upper side, LE
};

/// The thickness form NACA 65-010 (Abbott and von Doenhoff 1959, appendix I) scaled to 8 %, set perpendicularly on a
/// circular-arc camber line of 35 degrees as in cascade tests, with circles of 0.4 and 0.25 mm inscribed at LE and TE
/// that join the sides with the same tangent; chord 60 mm. The parallel curve at `offset_mm` outwards,
/// counter-clockwise, in steps below 3 um. Points and normals are exact. Nothing of cmm::fitting.
std::vector<OutlinePoint> outline(double offset_mm);

/// Counter-clockwise from one normal to the other, at `count` equal steps of angle but for both ends.
std::vector<Eigen::Vector2d> normals_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to, int count);

}  // namespace cmm::fitting::naca65
