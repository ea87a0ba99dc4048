// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// On which side of the travel the material lies: left for a counter-clockwise scan (outward normal to the right).
enum class MaterialSide : std::uint8_t { left, right };

/// The side, from the outward normal at the first touch and the direction of the first move.
MaterialSide material_side(const Vec2& outward_normal, const Vec2& travel);

/// The curve of ball centres while it is scanned: local frame at the last point, prediction of the next one, closing.
/// `add` costs a constant time (a robust fit over a trailing window) and allocates nothing below the reserved size.
/// One owner, no locking, millimetres.
class LiveCurve {
  public:
    struct Local {
        bool valid = false;            ///< false below 3 points
        Vec2 position = Vec2::Zero();  ///< smoothed last centre
        Vec2 tangent = Vec2::UnitX();  ///< unit, direction of travel
        Vec2 normal = Vec2::UnitY();   ///< unit, out of the material
        double curvature = 0.0;        ///< 1/mm, positive where the section is convex
        bool last_is_bad = false;      ///< the newest point disagrees with its predecessors
    };
    struct Prediction {
        bool valid = false;
        Vec2 centre = Vec2::Zero();
        Vec2 normal = Vec2::UnitY();  ///< out of the material at the predicted centre
    };

    explicit LiveCurve(MaterialSide side, std::size_t reserve = 4096);

    /// Points that are not finite or that repeat the last one are ignored.
    void add(const Vec2& centre);

    std::size_t size() const { return points_.size(); }
    const std::vector<Vec2>& points() const { return points_; }
    const Local& local() const { return local_; }
    /// The arc of the local circle, `step_mm` ahead.
    Prediction predict(double step_mm) const;
    /// sqrt(8 e / kappa) (seed 000, A2) within [min, max]: the step whose chord error is e; the
    /// least step while the newest point is in doubt.
    double suggest_step(double min_mm, double max_mm, double chord_error_mm) const;

    double length_mm() const { return length_; }
    /// Angle that the travel has turned since the start, positive towards the material: about +2 pi after one lap.
    double turned_rad() const { return turned_; }
    /// One lap is done: turned about 2 pi and the last step passed the first point within `lateral_tolerance_mm`.
    bool closed(double lateral_tolerance_mm = 0.5) const;

  private:
    void update_local();
    void publish(const Eigen::Vector3d& parabola, const Vec2& along, const Vec2& across, const Vec2& newest,
                 double half);
    void update_closing();

    double side_;  // +1: material on the left
    std::vector<Vec2> points_;
    Local local_;
    Vec2 start_tangent_ = Vec2::UnitX();
    bool start_known_ = false;
    double length_ = 0.0, turned_ = 0.0;
    double left_by_ = 0.0;          // how far the newest point was outside the curve before it
    double passed_lateral_ = -1.0;  // distance at which the start was passed, negative: not yet
};

}  // namespace cmm::fitting
