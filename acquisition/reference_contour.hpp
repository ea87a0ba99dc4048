// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/nominal.hpp"
#include "fitting/closed_curve.hpp"
#include "fitting/hollows.hpp"
#include "fitting/section.hpp"

namespace cmm::acquisition {

/// By what lean of the walls the error of the 2-D offset is counted: the nominal's, or, while nothing of a part's own
/// lean has been measured, one that is so much steeper.
enum class Lean { nominal, doubted };
inline constexpr double lean_doubt_rad = 0.0523599;  // 3 degrees; a blade 60 mm high that is bent by 3 mm at its tip

/// A nominal contour as a measured one can be compared with it: reduced to what the ball can touch, and with the lean
/// of the surface. In its hollows (concave corners and steps sharper than the ball) nothing is compared, unless they
/// are shallower than 5 um: there the ball's own arc is the nominal. Made once per section, with all that does not
/// depend on the measurement; immutable, any thread; part frame, mm.
class ReferenceContour {
  public:
    ReferenceContour(const NominalContour& contour, fitting::ClosedCurve curve, double ball_radius_mm);

    const std::vector<Eigen::Vector2d>& points() const { return points_; }
    const std::vector<fitting::Hollow>& hollows() const { return hollows_; }

    /// Signed distance of each contour point along the normal of the nominal (positive: too much material), foot on the
    /// side whose outward normal agrees with the point's, so that a thin edge is never compared with its other side.
    /// Empty where the ball does not reach the nominal, or rests in a hollow of the part, and in gaps. Writes into each
    /// point that was compensated in two dimensions what that makes too thick there (A22, by the nominal's lean) and
    /// adds it to the point's uncertainty: its sign is known, but it is not corrected; and how the nominal rises there.
    std::vector<std::optional<double>> compare(std::span<fitting::ContourPoint> contour,
                                               Lean lean = Lean::nominal) const;

    /// The same for one place of the part, as above.
    struct Comparison {
        std::optional<double> deviation_mm;
        double offset_error_mm = 0.0, doubted_error_mm = 0.0;  ///< by the nominal's lean, by the doubted one
        double s_mm = 0.0;                                     ///< arc length of the foot on the nominal
        double rise = 0.0;                                     ///< tangent of the nominal's lean there, where known
    };
    /// `near_mm`: arc length of a foot nearby, where one is known. Constant time with it.
    Comparison compare(const Eigen::Vector2d& position_mm, const Eigen::Vector2d& normal,
                       std::optional<double> near_mm) const;

    /// The nominal's lean beside each contour point, as above; of a nominal that knows the steepest only, that one.
    std::vector<double> leans_along(std::span<const fitting::ContourPoint> contour) const;

    /// Whether the nominal has tolerances at its points.
    bool has_tolerances() const { return !tolerances_.empty(); }
    /// At an arc length, linear between the nominal's points. Only with tolerances.
    PointTolerance tolerance_at(double s_mm) const;
    /// Whether the nominal says which way it leans, and not only how steep it is at most.
    bool knows_lean() const { return knows_lean_; }
    /// Outward unit normal of the nominal surface where a ball with this centre in the section's plane would touch it;
    /// `outward`: the way in which the part is sought, unit.
    Eigen::Vector3d touched_normal(const Eigen::Vector2d& centre_mm, const Eigen::Vector2d& outward) const;

  private:
    struct Station {
        Eigen::Vector2d position, normal;
        double lean_rad, offset_error_mm, doubted_error_mm, rise;
        bool reached;
    };
    struct Match {
        double deviation_mm, s_mm;
        const Station* station;  ///< nullptr: none that the ball reaches faces the point's way
        double offset_error_mm(Lean lean) const;
        double rise() const;
    };

    double station_mm(std::size_t i) const;
    const Station& station_at(double s_mm) const;
    const Station* nearest_station(const fitting::ContourPoint& point) const;
    Match match(const fitting::ContourPoint& point, const fitting::ClosestPoint& foot) const;
    std::vector<Match> matches(std::span<const fitting::ContourPoint> contour) const;
    std::optional<double> deviation(const fitting::ContourPoint& point, const Match& matched) const;
    const fitting::Hollow* hollow_below(const fitting::ContourPoint& point) const;

    std::vector<Eigen::Vector2d> points_;
    bool knows_lean_;
    fitting::ClosedCurve curve_;
    std::vector<fitting::Hollow> hollows_;
    std::vector<Station> stations_;
    std::vector<PointTolerance> tolerances_;  // at each point
    std::vector<double> tolerance_share_;     // of the length, where; ends with 1
};

}  // namespace cmm::acquisition
