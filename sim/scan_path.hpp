// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <span>

namespace cmm::sim {

struct PathPoint {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< expected ball centre, mm
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   ///< unit, out of the material
    double speed_mm_s = 0.0;                             ///< towards this point
    bool record = false;
    bool last = false;
};

/// The limits under which a path is run.
struct PathLimits {
    double max_speed_mm_s = 0.0;
    double max_accel_mm_s2 = 1.0;
    double tick_s = 0.0;  ///< sample clock: two recorded points are at least this far apart in time
};

/// The path that arrives in windows, and how fast it may be run with what is known of it so far (look-ahead): the speed
/// never exceeds what allows a halt at the last point received. Points behind the probe are forgotten. One thread.
class ScanPath {
  public:
    enum class Append : std::uint8_t { taken, repeated, invalid, full };

    void begin(std::uint16_t id, std::size_t capacity, const PathLimits& limits);
    Append append(std::uint32_t first, std::span<const PathPoint> points);
    /// The probe is at point `index`: what is more than one point behind is forgotten.
    void pass(std::uint32_t index);

    std::uint16_t id() const { return id_; }
    std::uint32_t received() const { return base_ + static_cast<std::uint32_t>(points_.size()); }
    bool has(std::uint32_t index) const { return index >= base_ && index < received(); }
    const PathPoint& at(std::uint32_t index) const { return points_[index - base_]; }

    /// Way from the point before to this one.
    double step_mm(std::uint32_t index) const;
    /// Largest speed between the point before and this one.
    double segment_speed(std::uint32_t index) const;
    /// Largest speed at this point: its segments, the centripetal acceleration, and the halt at the end of what is
    /// known.
    double point_speed(std::uint32_t index) const;
    /// Turning of the normal from the point before to this one, 1/mm. Looks back only, so it does not depend on how
    /// much of the path has arrived.
    double turning_per_mm(std::uint32_t index) const;

  private:
    double local_speed(std::uint32_t index) const;
    std::uint16_t id_ = 0;
    std::size_t capacity_ = 0;
    PathLimits limits_;
    std::deque<PathPoint> points_;
    std::uint32_t base_ = 0;    // index of points_.front()
    std::uint32_t passed_ = 0;  // points at or behind the probe
};

}  // namespace cmm::sim
