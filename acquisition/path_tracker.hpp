// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace cmm::acquisition {

/// Position and heading on an unknown ball-centre curve, from its points one by one, counter-clockwise round the
/// material. What the ball can do bounds what a point may say: a convex turn is never tighter than the ball, so a point
/// farther in than that, or out of all proportion, is bad and changes nothing; four such points in a row mean that the
/// heading was wrong, and it is found anew from the last points by least median of squares. One owner, no locking,
/// millimetres.
class PathTracker {
  public:
    /// `heading` is a guess until the first nine points are there.
    PathTracker(double ball_radius_mm, const Eigen::Vector2d& heading);

    void add(const Eigen::Vector2d& centre);
    /// The ball lost the surface: if the last point was rejected for turning in, it was right after all.
    void lost_contact();
    /// Contact again after a search: at this point, in about this direction.
    void regained_contact(const Eigen::Vector2d& centre, const Eigen::Vector2d& heading);

    bool ready() const { return ready_; }
    const Eigen::Vector2d& position() const { return position_; }
    const Eigen::Vector2d& tangent() const { return tangent_; }
    /// Averaged over half a millimetre: for the prediction.
    double curvature() const { return curvature_; }
    /// The largest that the last points leave possible: for the step.
    double sharpest_curvature() const { return sharpest_; }
    std::size_t rejected_in_row() const { return rejected_; }
    double length_mm() const { return length_; }
    /// Angle turned since the start, positive to the left: 2 pi after a lap.
    double turned_rad() const { return turned_; }
    /// Whether the start was passed after about a full turn.
    bool closed() const { return closed_; }

  private:
    /// y = a + b x + c x^2 with x along `along_` and y to its left, from `origin`.
    struct Parabola {
        Eigen::Vector2d origin, along;
        Eigen::Vector3d coefficients;
        double at(double x) const;
        double slope(double x) const { return coefficients[1] + 2.0 * coefficients[2] * x; }
        Eigen::Vector2d local(const Eigen::Vector2d& p) const;
        Eigen::Vector2d tangent(double x) const;
        Eigen::Vector2d point(double x) const;
    };
    struct Weighted {
        Eigen::Vector2d point;
        double weight;
    };
    static Parabola fit(const std::vector<Weighted>& points, const Eigen::Vector2d& origin,
                        const Eigen::Vector2d& along);

    static std::vector<double> residuals(const Parabola& parabola, const std::vector<Eigen::Vector2d>& points);
    std::vector<Eigen::Vector2d> most_agreed(const std::vector<Eigen::Vector2d>& points) const;
    bool plausible(const Eigen::Vector2d& centre) const;
    void reacquire();
    void update();
    void restart(std::vector<Eigen::Vector2d> points, const Eigen::Vector2d& heading);
    void expect_turn(const Eigen::Vector2d& centre);
    void advance(const Eigen::Vector2d& position, const Eigen::Vector2d& tangent);

    double radius_;
    std::vector<Eigen::Vector2d> raw_, good_;
    Eigen::Vector2d position_ = Eigen::Vector2d::Zero(), tangent_;
    Eigen::Vector2d start_ = Eigen::Vector2d::Zero(), start_tangent_ = Eigen::Vector2d::UnitX();
    double curvature_ = 0.0, sharpest_ = 0.0;
    double doubt_rad_ = 0.0;  // how much more the heading may have turned in than the last points show
    std::size_t rejected_ = 0;
    double length_ = 0.0, turned_ = 0.0;
    bool ready_ = false, closed_ = false;
};

}  // namespace cmm::acquisition
