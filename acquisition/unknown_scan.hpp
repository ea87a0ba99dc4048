// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "acquisition/part_file.hpp"
#include "acquisition/path_tracker.hpp"
#include "core/error.hpp"
#include "drivers/machine.hpp"

namespace cmm::acquisition {

struct UnknownScanOptions {
    double ball_radius_mm = 1.0;
    double pitch_mm = 0.4;
    double edge_density = 4.0;
    double max_speed_mm_s = 10.0;
    double chord_error_mm = 1e-3;  ///< e of the step sqrt(8 e / kappa) between pitch and pitch / edge_density
    double longest_mm = 1000.0;    ///< give up after so much path without closing
    std::size_t overlap = 3;       ///< points past the start
};

/// Pitch, density, speed and the length limit (four perimeters of the box) from a part file of nominal "none".
UnknownScanOptions unknown_scan_options(const PartFile& part);

/// The path round a section that nobody knows: from the first touch on every point is predicted from those before it,
/// until the start is passed. One point at a time, each after the sample of the one before: what is scanned does not
/// depend on timing. Machine's executor only, as its base says; lives through one scan. Millimetres, part frame =
/// machine frame.
class UnknownScan final : public drivers::PathSource {
  public:
    /// `touch_mm` is the ball centre of the first touch, `outward` roughly the normal there (to 45 degrees).
    UnknownScan(const UnknownScanOptions& options, const Eigen::Vector3d& touch_mm, const Eigen::Vector2d& outward);

    std::size_t next(std::span<drivers::PathPoint> room, bool& last) override;
    /// The sample of the point given last. Errors: fit_not_evaluable (surface lost for 2 mm, or no closing): stop the
    /// scan.
    core::Status on_sample(const Eigen::Vector3d& centre_mm, bool no_contact);

    bool closed() const { return tracker_.closed(); }
    const PathTracker& tracker() const { return tracker_; }

  private:
    drivers::PathPoint predicted();
    drivers::PathPoint path_point(const Eigen::Vector2d& centre, const Eigen::Vector2d& tangent, double step) const;
    double wanted_step() const;

    UnknownScanOptions options_;
    double z_;
    Eigen::Vector2d first_, heading_;
    PathTracker tracker_;
    double finest_, widest_;
    double step_;                       // of the last point
    double ahead_ = 0.0;                // how far the last point lay ahead of the tracker's position
    std::size_t given_ = 0, lost_ = 0;  // points given; of them without contact, in a row
    double lost_mm_ = 0.0;
    std::optional<std::size_t> past_start_;
    Eigen::Vector2d last_given_ = Eigen::Vector2d::Zero(), last_tangent_ = Eigen::Vector2d::UnitX();
    bool waiting_ = false, ended_ = false;
};

}  // namespace cmm::acquisition
