// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace cmm::sim {

/// A trapezoidal speed profile over one straight distance: from `v0` with the acceleration up to at most `v_max`, then
/// down to `v1`. Millimetres and seconds. The caller makes sure that v1 can be reached (|v1^2 - v0^2| <= 2 a length)
/// and that v0, v1 <= v_max. A value.
class Ramp {
  public:
    Ramp() = default;
    Ramp(double length_mm, double v0, double v1, double v_max, double accel);

    double length() const { return length_; }
    double duration() const { return up_s_ + even_s_ + down_s_; }
    /// Way and speed after `t` seconds, clamped to the profile.
    double distance_at(double t) const;
    double speed_at(double t) const;
    /// When the way is `distance`; clamped.
    double time_at(double distance) const;

  private:
    double length_ = 0.0, v0_ = 0.0, v1_ = 0.0, peak_ = 0.0, accel_ = 1.0;
    double up_s_ = 0.0, even_s_ = 0.0, down_s_ = 0.0;
};

}  // namespace cmm::sim
