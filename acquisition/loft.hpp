// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "acquisition/contour_sampling.hpp"
#include "acquisition/cubic_spline.hpp"

namespace cmm::acquisition {

/// The surface through closed profiles that run the same way round and ascend in z (docs/part-file.md, "Loft"):
/// periodic cubic splines along the profiles, a natural cubic spline across. Immutable, thread-safe. Millimetres, span
/// along +z.
class Loft {
  public:
    /// At least 2 profiles with at least 3 points each, as many in each; none repeats the one before in all of them.
    explicit Loft(std::vector<std::vector<Eigen::Vector3d>> profiles);

    /// The parts of the span where every point of the profiles has a point of that height.
    double z_low_mm() const { return z_low_; }
    double z_high_mm() const { return z_high_; }
    /// The plane cut, sampled densely in running order; z must lie within the range.
    std::vector<CutPoint> cut(double z_mm) const;

  private:
    CutPoint at(double u, double z_mm) const;

    std::vector<CubicSpline> along_;
    std::vector<double> across_knots_;
    std::vector<double> coarse_;  // parameters along the profiles, several between two points
    double z_low_ = 0.0, z_high_ = 0.0;
};

}  // namespace cmm::acquisition
