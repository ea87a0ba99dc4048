// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cmm::fitting {

/// A place where the curvature of a closed curve jumps, as where an edge's arc meets a side.
struct CurvatureJoint {
    double t = 0.0;                             ///< parameter
    double step = 0.0;                          ///< of the curvature, 1/mm
    double ramp_step = 0.0;                     ///< the same by the ramp
    double width_mm = 0.0;                      ///< the ramp that a curve without joint makes of it
    std::size_t first_span = 0, last_span = 0;  ///< that the ramp covers
    double from_t = 0.0, to_t = 0.0;            ///< the same by parameter: joints stay apart from each other
    bool supposed = false;                      ///< no ramp shows it
    double told_sigma_mm = 0.0;                 ///< its place is told, with this standard deviation; 0: it is not
};

/// Finds the ramps of a cubic spline's curvature that stand for jumps: one to four spans over which it changes at once,
/// four times as steeply as before and behind, and by so much that the ramp is off a true jump by more than a third of
/// `sigma_mm`. `breaks`: spans + 1 parameters; `slope`: of the curvature by length in each span, 1/mm^2; `length`: of
/// the spans, mm. O(spans).
std::vector<CurvatureJoint> find_curvature_joints(std::span<const double> breaks, std::span<const double> slope,
                                                  std::span<const double> length, double sigma_mm);

/// Where a slope of the curvature ends at once and it is level beyond, on the side of the smaller curvature (the end of
/// an ellipse), there may be a jump that the curve has joined with the slope. Adds such places, the larger first, apart
/// from the `joints` that there are, but for those by a ramp that has less than half of such a step next to it or runs
/// the other way: what they saw is noise on the slope. Whether the added ones are any, the points must tell.
void add_supposed_joints(std::span<const double> breaks, std::span<const double> slope, std::span<const double> length,
                         double sigma_mm, std::vector<CurvatureJoint>& joints);

/// Knots that stand close together.
struct KnotCluster {
    std::size_t first = 0;  ///< index of the first one
    double apart = 0.0;     ///< of neighbours, by parameter
};

/// The breaks with `knots` of them round each place, `share` of a span apart, instead of those that were nearer to it
/// than a third of a span: between two the curvature may jump, between three the tangent may turn. `places` ascend;
/// what is written to `at` goes with them. The first and the last break stay.
std::vector<double> breaks_with_joints(std::span<const double> breaks, std::span<const double> places,
                                       std::size_t knots, double share, std::vector<KnotCluster>& at);

}  // namespace cmm::fitting
