// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/arc_length.hpp"
#include "fitting/smoothing.hpp"

namespace cmm::fitting {

/// A joint of the curvature on a row.
struct RowJoint {
    double s_mm = 0.0;  ///< arc length
    double step = 0.0;  ///< of the curvature, 1/mm
};

/// A closed row of a surface: the smooth curve through its points in the plane z = const, and what of it corresponds to
/// the other rows. Arc lengths in mm from the start of the curve.
class SurfaceRow {
  public:
    /// Counter-clockwise from the LE: its nose, its end; the TE's beginning, nose and end; the LE's beginning.
    static constexpr std::size_t feature_count = 6;
    enum Feature : std::size_t { le_nose, le_end, te_begin, te_nose, te_end, le_begin };

    /// LE and TE are sought on the parallel curve `ball_radius_mm` inside (0: on the curve itself), near the hints
    /// where given (those of the row below). Errors: fit_not_evaluable (no two edges, z not finite).
    static core::Result<SurfaceRow> make(SmoothCurve smooth, double z_mm, double ball_radius_mm,
                                         const std::optional<Vec2>& le_hint = {},
                                         const std::optional<Vec2>& te_hint = {});

    double z_mm() const { return z_mm_; }
    double length_mm() const { return arc_.total(); }
    const SmoothCurve& smooth() const { return smooth_; }
    const std::array<double, feature_count>& features() const { return features_; }
    /// Where the curvature jumps beside that end of an edge; none at noses.
    const std::array<std::optional<RowJoint>, feature_count>& joints() const { return joints_; }
    const Vec2& le() const { return le_; }
    const Vec2& te() const { return te_; }
    /// The point at an arc length, any turn; its parameter on the curve.
    Vec2 at(double s_mm) const;
    double parameter(double s_mm) const;
    /// The same points smoothed anew with these joints (smooth_with_joints), from half-way along a side; edges and
    /// noses are where they were.
    core::Result<SurfaceRow> with_joints(std::vector<KnownJoint> joints) const;

  private:
    double z_mm_ = 0.0;
    SmoothCurve smooth_;
    ArcLength arc_;
    void find_joints();
    CurvePlace place_at(double s_mm) const;

    std::array<double, feature_count> features_{};
    std::array<std::optional<RowJoint>, feature_count> joints_;
    Vec2 le_, te_;
};

/// One parameter u in [0, period) for all rows, in which LE, TE and their ends have the same place on every row (seed
/// 001, B11; LE and TE aligned as features): arc length of the mean row, from the LE nose. Where the edges end is
/// smoothed over the rows, since each row tells it only roughly; where most rows know a joint of the curvature there,
/// the joints are the ends.
class RowAlignment {
  public:
    explicit RowAlignment(std::span<const SurfaceRow> rows);

    double period() const { return period_; }
    /// Ends of edges that are joints of the curvature, ascending.
    const std::vector<double>& joints() const { return joints_; }
    /// Where the rows together have the joints of one of them: its arc length, and the standard deviation of that.
    struct CommonJoint {
        SurfaceRow::Feature end;
        double s_mm, sigma_mm;
    };
    std::vector<CommonJoint> joints_on(std::size_t row) const;
    /// Arc length on a row at u: monotone cubic through the features (Fritsch and Carlson 1980).
    double arc_length(std::size_t row, double u) const;

  private:
    static constexpr std::size_t count = SurfaceRow::feature_count;
    struct Map {
        std::array<double, count + 1> s, slope;
    };
    std::vector<double> joints_;
    std::array<std::vector<double>, count> joint_sigma_mm_;  // by row; empty: no joint there
    std::array<double, count + 1> u_{};
    std::vector<Map> maps_;
    double period_ = 0.0;
};

/// A joint of the curvature is an edge of the part: where most rows know one, all rows have it, where they together
/// say. Those rows are smoothed anew with the common joints and no others: a joint that noise hid in one row, put in
/// the wrong place or feigned costs some micrometres there. A row whose points do not bear them stays as it is.
std::vector<SurfaceRow> settle_joints(std::span<const SurfaceRow> rows);

}  // namespace cmm::fitting
