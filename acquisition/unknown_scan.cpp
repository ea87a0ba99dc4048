// SPDX-License-Identifier: Apache-2.0
#include "acquisition/unknown_scan.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "acquisition/plan.hpp"
#include "core/text.hpp"
#include "fitting/vec2.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;
using Eigen::Vector2d;
using fitting::left_of;

constexpr double step_growth = 1.3;
// The centre runs at least a ball radius round any edge: a step of less than that still finds the surface under it.
constexpr double widest_of_ball = 0.7, finest_of_ball = 0.3;
constexpr double lost_limit_mm = 2.0;
constexpr double start_window_mm = 2.0;  // the start counts as passed when it is nearer than this
// Contacts until the curve is believed: at the start, after a search, and where so many in a row did not fit it.
constexpr std::size_t first_points = 6, points_after_search = 2, doubtful_in_row = 3;
constexpr double most_turn_rad = 0.5;  // between two of them
// Where the surface is sought after points without contact: a spiral into the material, for an edge that was overrun,
// and now and then outwards, for the far wall of a dent that blocks the way.
constexpr std::array<double, 8> search_turns_rad{0.5, 1.0, -0.8, 1.5, -1.6, 2.0, -2.4, 2.5};

Vector2d right_of(const Vector2d& v) {
    return -left_of(v);
}

/// A heading that turns towards a way, but not by more than an edge under a small ball.
Vector2d turned_towards(const Vector2d& heading, const Vector2d& way) {
    const double turn = std::atan2(fitting::cross(heading, way), heading.dot(way));
    return Eigen::Rotation2Dd(std::clamp(turn, -most_turn_rad, most_turn_rad)) * heading;
}

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
      finest_(std::min(options.pitch_mm / options.edge_density, finest_of_ball * options.ball_radius_mm)),
      widest_(std::max(finest_, std::min(options.pitch_mm, widest_of_ball * options.ball_radius_mm))),
      step_(finest_),
      from_(touch_mm.head<2>()),
      heading_(left_of(outward).normalized()),  // the material to the left: counter-clockwise
      rough_(first_points),
      given_(from_),
      given_heading_(heading_) {}

std::size_t UnknownScan::next(std::span<drivers::PathPoint> room, bool& last) {
    if (ended_) {
        last = true;
        return 0;
    }
    if (waiting_) return 0;
    room[0] = predicted();
    const Vector2d centre = room[0].centre_mm.head<2>();
    if (lost_ > 0) lost_mm_ += (centre - given_).norm();
    given_ = centre;
    given_heading_ = left_of(Vector2d(room[0].normal.head<2>()));
    waiting_ = true;
    if (past_start_ && ++*past_start_ >= options_.overlap) last = ended_ = true;
    return 1;
}

drivers::PathPoint UnknownScan::path_point(const Vector2d& centre, const Vector2d& normal) const {
    drivers::PathPoint point;
    point.centre_mm = {centre.x(), centre.y(), z_};
    point.normal = {normal.x(), normal.y(), 0.0};
    point.speed_mm_s = scanning_speed_mm_s(step_, options_.pitch_mm, options_.max_speed_mm_s);
    return point;
}

drivers::PathPoint UnknownScan::straight_on() const {
    const double turn = lost_ > 0 ? search_turns_rad.at((lost_ - 1) % search_turns_rad.size()) : 0.0;
    const Vector2d heading = Eigen::Rotation2Dd(turn) * heading_;
    const bool first = samples_ == 0;
    return path_point(from_ + (first ? 0.0 : finest_) * heading, right_of(heading));
}

drivers::PathPoint UnknownScan::predicted() {
    const auto here = curve_.newest();
    const auto wanted = curve_.suggest_step(finest_, widest_, options_.chord_error_mm);
    step_ = std::min(wanted, step_growth * step_);
    const auto ahead = curve_.predict(step_);
    if (lost_ == 0 && rough_ == 0 && here.valid && ahead.valid) return path_point(ahead.centre, ahead.normal);
    step_ = finest_;
    return straight_on();
}

/// While the curve is not yet sure again, or not any more, the last two contacts say where to go.
void UnknownScan::follow(const Vector2d& contact) {
    const auto here = curve_.newest();
    doubtful_ = here.valid && here.doubtful ? doubtful_ + 1 : 0;
    const Vector2d way = contact - from_;
    if (lost_ > 0) {
        heading_ = given_heading_;
        rough_ = points_after_search;
    } else if (rough_ > 0) {
        --rough_;
        if (samples_ > first_points) heading_ = turned_towards(heading_, way);
    } else if (doubtful_ >= doubtful_in_row) {
        heading_ = turned_towards(here.tangent, way);
        rough_ = points_after_search;
        doubtful_ = 0;
    }
    from_ = contact;
}

core::Status UnknownScan::on_sample(const Eigen::Vector3d& centre_mm, bool no_contact) {
    waiting_ = false;
    curve_.add(++samples_, centre_mm.head<2>(), no_contact);
    const auto here = curve_.newest();
    if (no_contact) {
        // Sought from the last place and direction that the curve was sure of.
        if (lost_ == 0 && rough_ == 0 && here.valid) {
            from_ = here.position;
            heading_ = here.tangent;
        }
        ++lost_;
        if (lost_mm_ <= lost_limit_mm) return {};
        return core::fail(ErrorCode::fit_not_evaluable,
                          "the surface was lost near x " + core::fixed(from_.x(), 3) + ", y " +
                              core::fixed(from_.y(), 3) + " mm: no contact over " + core::length_text(lost_mm_) +
                              " of path",
                          core::Motion::may_be_moving);
    }
    follow(centre_mm.head<2>());
    lost_ = 0;
    lost_mm_ = 0.0;
    if (curve_.closed(start_window_mm) && !past_start_) past_start_ = 0;
    if (curve_.length_mm() <= options_.longest_mm) return {};
    return core::fail(
        ErrorCode::fit_not_evaluable,
        "the section does not close: " + core::length_text(curve_.length_mm()) + " of path, four times round the box",
        core::Motion::may_be_moving);
}

}  // namespace cmm::acquisition
