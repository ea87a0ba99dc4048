// SPDX-License-Identifier: Apache-2.0
#include "acquisition/hand_lap.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cmm::acquisition {
namespace {

// Shorter steps say more about the hand than about the part.
constexpr double shortest_side_mm = 0.5;
// The far side of a thin blade is half a turn away, the start a whole one.
constexpr double nearly_round_rad = 1.6 * std::numbers::pi;
constexpr double near_start_mm = 1.0;
constexpr double near_start_steps = 2.0;

}  // namespace

double HandLap::ahead_of_start(const Eigen::Vector2d& centre) const {
    return (centre - *start_).dot(*start_direction_);
}

void HandLap::turn_to(const Eigen::Vector2d& centre) {
    const Eigen::Vector2d side = centre - *corner_;
    const double length = side.norm();
    if (length < shortest_side_mm) return;
    const Eigen::Vector2d direction = side / length;
    if (direction_) {
        const double sine = direction_->x() * direction.y() - direction_->y() * direction.x();
        turned_rad_ += std::atan2(sine, direction_->dot(direction));
    } else {
        start_direction_ = direction;
    }
    direction_ = direction;
    corner_ = centre;
}

void HandLap::add(const Eigen::Vector2d& centre) {
    if (!start_) {
        start_ = corner_ = last_ = centre;
        return;
    }
    const Eigen::Vector2d before = last_;
    last_ = centre;
    turn_to(centre);
    if (std::abs(turned_rad_) < nearly_round_rad) return;
    const double near_mm = std::max(near_start_mm, near_start_steps * (centre - before).norm());
    const bool crossed = ahead_of_start(before) < 0.0 && ahead_of_start(centre) >= 0.0;
    closed_ = closed_ || (crossed && (centre - *start_).norm() <= near_mm);
}

}  // namespace cmm::acquisition
