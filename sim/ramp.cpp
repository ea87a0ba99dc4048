// SPDX-License-Identifier: Apache-2.0
#include "sim/ramp.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::sim {

Ramp::Ramp(double length_mm, double v0, double v1, double v_max, double accel)
    : length_(length_mm), v0_(v0), v1_(v1), accel_(accel) {
    if (length_mm <= 0.0) return;
    // Without a speed limit the two ramps meet at peak^2 = a length + (v0^2 + v1^2) / 2.
    const double meeting = std::sqrt(accel * length_mm + (v0 * v0 + v1 * v1) / 2.0);
    peak_ = std::max({std::min(v_max, meeting), v0, v1});
    up_s_ = (peak_ - v0) / accel;
    down_s_ = (peak_ - v1) / accel;
    const double ramps = (2.0 * peak_ * peak_ - v0 * v0 - v1 * v1) / (2.0 * accel);
    even_s_ = std::max(0.0, length_mm - ramps) / peak_;
}

double Ramp::distance_at(double t) const {
    if (t <= 0.0) return 0.0;
    if (t >= duration()) return length_;
    if (t < up_s_) return v0_ * t + accel_ * t * t / 2.0;
    const double up = (peak_ + v0_) / 2.0 * up_s_;
    if (t < up_s_ + even_s_) return up + peak_ * (t - up_s_);
    const double left = duration() - t;
    return length_ - (v1_ * left + accel_ * left * left / 2.0);
}

double Ramp::speed_at(double t) const {
    if (t <= 0.0) return v0_;
    if (t >= duration()) return v1_;
    if (t < up_s_) return v0_ + accel_ * t;
    if (t < up_s_ + even_s_) return peak_;
    return v1_ + accel_ * (duration() - t);
}

double Ramp::time_at(double distance) const {
    if (distance <= 0.0) return 0.0;
    if (distance >= length_) return duration();
    const double up = (peak_ + v0_) / 2.0 * up_s_;
    if (distance < up) return (std::sqrt(v0_ * v0_ + 2.0 * accel_ * distance) - v0_) / accel_;
    if (distance < up + peak_ * even_s_) return up_s_ + (distance - up) / peak_;
    const double left = length_ - distance;
    return duration() - (std::sqrt(v1_ * v1_ + 2.0 * accel_ * left) - v1_) / accel_;
}

}  // namespace cmm::sim
