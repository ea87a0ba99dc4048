// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "fitting/contour_geometry.hpp"
#include "fitting/sensitivity.hpp"

namespace cmm::fitting {

/// The curvature of a contour as its mean over a window of arc length, 1/mm, positive where the part is convex. The
/// weights are (1 - u^2)^2, u = -1 ... 1 along the window: with them the mean of a gently bent stretch is the curvature
/// of the least-squares parabola through it (Savitzky and Golay 1964 with their sum as an integral, by parts twice),
/// and of an arc it is 1/r however far it turns. A curvature at a point is that of no real surface: it depends on the
/// scale on which one looks, and a fit has one of its own. With the window it is said, the same for part and nominal.
/// Between two contour points the direction turns evenly. Refers to the contour, which must outlive it; any thread.
class MeanCurvature {
  public:
    /// `window_mm` shorter than half the perimeter.
    MeanCurvature(const ContourGeometry& contour, double window_mm);

    double window_mm() const { return 2.0 * half_mm_; }
    /// About a place by its arc length from the contour's first point, taken round the end.
    double at(double s_mm) const;
    /// How many stretches between contour points such a window holds, in part or as a whole.
    std::size_t stretches(double s_mm) const;
    /// How that answers to displacements of the contour, the window being carried along with its middle. O(points of
    /// the window).
    Sensitivity slopes(double s_mm) const;

  private:
    /// A stretch between two neighbouring points, as far as the window holds it.
    struct Stretch {
        std::size_t point = 0;        ///< its first one
        double from = 0.0, to = 0.0;  ///< u
        double curvature = 0.0;
    };
    template <typename Visit>
    void visit(double s_mm, const Visit& visit) const;

    const ContourGeometry* contour_;
    double half_mm_;
    std::vector<double> arc_mm_, turn_;  // of each point, and of the first one again
};

}  // namespace cmm::fitting
