// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "acquisition/part_file.hpp"
#include "core/error.hpp"
#include "drivers/machine.hpp"
#include "fitting/live_spline.hpp"

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

/// The path round a section that nobody knows: from the first touch on every point is predicted by the live curve of
/// those before it (docs/theory.md, section 9), until the start is passed. One point at a time, each after the sample
/// of the one before: what is scanned does not depend on timing. Machine's executor only, as its base says; lives
/// through one scan. Millimetres, part frame = machine frame.
class UnknownScan final : public drivers::PathSource {
  public:
    /// `touch_mm` is the ball centre of the first touch, `outward` roughly the normal there (to 45 degrees).
    UnknownScan(const UnknownScanOptions& options, const Eigen::Vector3d& touch_mm, const Eigen::Vector2d& outward);

    std::size_t next(std::span<drivers::PathPoint> room, bool& last) override;
    /// The sample of the point given last. Errors: fit_not_evaluable (surface lost for 2 mm, or no closing): stop the
    /// scan.
    core::Status on_sample(const Eigen::Vector3d& centre_mm, bool no_contact);

    bool closed() const { return past_start_.has_value(); }

  private:
    drivers::PathPoint predicted();
    drivers::PathPoint path_point(const Eigen::Vector2d& centre, const Eigen::Vector2d& normal) const;
    drivers::PathPoint straight_on() const;
    void follow(const Eigen::Vector2d& contact);

    UnknownScanOptions options_;
    double z_;
    fitting::LiveSpline curve_{fitting::MaterialSide::left};  // counter-clockwise
    double finest_, widest_;
    double step_;                            // of the last point
    Eigen::Vector2d from_, heading_;         // the last contact, and where to go from there as long as ...
    std::size_t rough_;                      // ... so many contacts are still wanted for a curve
    std::size_t doubtful_ = 0;               // in a row
    std::size_t samples_ = 0, lost_ = 0;     // of them without contact, in a row
    double lost_mm_ = 0.0;                   // path of these
    Eigen::Vector2d given_, given_heading_;  // the last point
    std::optional<std::size_t> past_start_;
    bool waiting_ = false, ended_ = false;
};

}  // namespace cmm::acquisition
