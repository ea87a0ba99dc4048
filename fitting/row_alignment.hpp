// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "fitting/row_features.hpp"

namespace cmm::fitting {

/// One parameter u in [0, period) for all rows, in which LE, TE and their ends have the same place on every row (seed
/// 001, B11; LE and TE aligned as features): arc length of the mean row, from the LE nose. Where the edges end is
/// smoothed over the rows, since each row tells it only roughly; where most rows know a joint of the curvature there,
/// the joints are the ends.
class RowAlignment {
  public:
    explicit RowAlignment(std::span<const RowFeatures> rows);

    double period() const { return period_; }
    /// Where a feature is.
    double place(RowFeatures::Feature feature) const { return u_[feature]; }
    /// Ends of edges that are joints of the curvature, ascending.
    const std::vector<double>& joints() const { return joints_; }
    /// Where the rows together have a joint of one of them: its arc length, the standard deviation of that, and the
    /// step of the curvature.
    struct CommonJoint {
        double s_mm, sigma_mm, step;
    };
    std::vector<CommonJoint> joints_on(std::size_t row) const;
    /// Arc length on a row at u: monotone cubic through the features (Fritsch and Carlson 1980), linear along the
    /// middle half of each side.
    double arc_length(std::size_t row, double u) const;

  private:
    static constexpr std::size_t count = RowFeatures::count;
    static constexpr std::size_t knots = count + 5;  // the LE nose again, and two a side
    using AtFeatures = std::array<double, count + 1>;
    using AtKnots = std::array<double, knots>;
    struct Map {
        AtKnots s, slope;
    };
    static AtKnots with_quarters(const AtFeatures& at);
    Map map_of(const AtKnots& s) const;

    std::vector<double> joints_;
    std::array<std::vector<double>, count> joint_sigma_mm_, joint_step_;  // by row; empty: no joint there
    AtFeatures u_{};
    AtKnots knot_u_{};
    std::vector<Map> maps_;
    double period_ = 0.0;
};

}  // namespace cmm::fitting
