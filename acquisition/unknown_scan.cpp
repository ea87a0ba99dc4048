// SPDX-License-Identifier: Apache-2.0
#include "acquisition/unknown_scan.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "acquisition/plan.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;
using Eigen::Vector2d;

constexpr double step_growth = 1.3;
// The centre runs at least a ball radius round any edge: a step of less than that still finds the surface under it.
constexpr double widest_of_ball = 0.7, finest_of_ball = 0.3;
constexpr double lost_limit_mm = 2.0;
// Where the surface is sought after points without contact: a spiral into the material, for an edge that was overrun,
// and now and then outwards, for the far wall of a dent that blocks the way.
constexpr std::array<double, 8> search_turns_rad{0.5, 1.0, -0.8, 1.5, -1.6, 2.0, -2.4, 2.5};

}  // namespace

UnknownScanOptions unknown_scan_options(const PartFile& part) {
    UnknownScanOptions options;
    options.ball_radius_mm = part.stylus.radius_mm;
    options.pitch_mm = part.scan.pitch_mm;
    options.edge_density = part.scan.edge_density;
    options.max_speed_mm_s = part.scan.max_speed_mm_s;
    if (const auto& box = part.scan.box_mm) options.longest_mm = 8.0 * ((*box)[2] - (*box)[0] + (*box)[3] - (*box)[1]);
    return options;
}

UnknownScan::UnknownScan(const UnknownScanOptions& options, const Eigen::Vector3d& touch_mm, const Vector2d& outward)
    : options_(options),
      z_(touch_mm.z()),
      first_(touch_mm.head<2>()),
      heading_(Vector2d(-outward.y(), outward.x()).normalized()),  // the material to the left: counter-clockwise
      tracker_(options.ball_radius_mm, heading_),
      finest_(std::min(options.pitch_mm / options.edge_density, finest_of_ball * options.ball_radius_mm)),
      widest_(std::max(finest_, std::min(options.pitch_mm, widest_of_ball * options.ball_radius_mm))),
      step_(finest_) {}

std::size_t UnknownScan::next(std::span<drivers::PathPoint> room, bool& last) {
    if (ended_) {
        last = true;
        return 0;
    }
    if (waiting_) return 0;
    room[0] = predicted();
    const Vector2d centre = room[0].centre_mm.head<2>();
    if (lost_ > 0) lost_mm_ += (centre - last_given_).norm();
    last_given_ = centre;
    last_tangent_ = {-room[0].normal.y(), room[0].normal.x()};
    ++given_;
    waiting_ = true;
    if (past_start_ && ++*past_start_ >= options_.overlap) last = ended_ = true;
    return 1;
}

drivers::PathPoint UnknownScan::path_point(const Vector2d& centre, const Vector2d& tangent, double step) const {
    drivers::PathPoint point;
    point.centre_mm = {centre.x(), centre.y(), z_};
    point.normal = {tangent.y(), -tangent.x(), 0.0};
    point.speed_mm_s = scanning_speed_mm_s(step, options_.pitch_mm, options_.max_speed_mm_s);
    return point;
}

double UnknownScan::wanted_step() const {
    const double kappa = tracker_.sharpest_curvature();
    if (tracker_.rejected_in_row() > 0 || kappa <= 0.0)
        return tracker_.rejected_in_row() > 0 ? finest_ : std::min(widest_, step_growth * step_);
    return std::min(std::clamp(std::sqrt(8.0 * options_.chord_error_mm / kappa), finest_, widest_),
                    step_growth * step_);
}

drivers::PathPoint UnknownScan::predicted() {
    if (!tracker_.ready()) {
        // The first points run straight: which of them are good is known when all are there.
        return path_point(first_ + static_cast<double>(given_) * finest_ * heading_, heading_, finest_);
    }
    const Vector2d& tangent = tracker_.tangent();
    if (lost_ > 0) {
        step_ = finest_;
        const double turn = search_turns_rad.at((lost_ - 1) % search_turns_rad.size());
        const Vector2d turned = Eigen::Rotation2Dd(turn) * tangent;
        return path_point(tracker_.position() + finest_ * turned, turned, finest_);
    }
    step_ = wanted_step();
    // Points that were not believed leave the tracker behind: the next one lies beyond them.
    ahead_ = tracker_.rejected_in_row() == 0 ? step_ : ahead_ + step_;
    const double angle = tracker_.curvature() * ahead_;
    const Vector2d chord = Eigen::Rotation2Dd(0.5 * angle) * tangent;
    return path_point(tracker_.position() + ahead_ * chord, Eigen::Rotation2Dd(angle) * tangent, step_);
}

core::Status UnknownScan::on_sample(const Eigen::Vector3d& centre_mm, bool no_contact) {
    waiting_ = false;
    if (no_contact) {
        ++lost_;
        tracker_.lost_contact();
        if (lost_mm_ <= lost_limit_mm) return {};
        return core::fail(ErrorCode::fit_not_evaluable,
                          "the surface was lost near x " + core::fixed(tracker_.position().x(), 3) + ", y " +
                              core::fixed(tracker_.position().y(), 3) + " mm: no contact over " +
                              core::length_text(lost_mm_) + " of path",
                          core::Motion::may_be_moving);
    }
    if (lost_ > 0) {
        tracker_.regained_contact(centre_mm.head<2>(), last_tangent_);
    } else {
        tracker_.add(centre_mm.head<2>());
    }
    lost_ = 0;
    lost_mm_ = 0.0;
    if (tracker_.closed() && !past_start_) past_start_ = 0;
    if (tracker_.length_mm() <= options_.longest_mm) return {};
    return core::fail(
        ErrorCode::fit_not_evaluable,
        "the section does not close: " + core::length_text(tracker_.length_mm()) + " of path, four times round the box",
        core::Motion::may_be_moving);
}

}  // namespace cmm::acquisition
