// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <initializer_list>
#include <vector>

#include "core/clock.hpp"
#include "sim/controller.hpp"

namespace cmm::sim::test {

/// A round bar along z through the origin: every contact has a closed form.
class Bar final : public Surface {
  public:
    explicit Bar(double radius_mm) : radius_(radius_mm) {}
    Contact nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm) const override;
    Box box() const override { return {{-radius_, -radius_, -1000}, {radius_, radius_, 1000}}; }

  private:
    double radius_;
};

inline constexpr double bar_radius_mm = 10.0;
inline constexpr double ball_radius_mm = 1.0;
inline constexpr double circle_mm = bar_radius_mm + ball_radius_mm;  // of the ball's centre in contact

ControllerOptions bar_options();

/// `count` recorded points along the ball's circle about the bar at height z, from the angle `from_rad`, the last one
/// flagged.
std::vector<PathPoint> arc_path(int count, double step_rad, double speed_mm_s, double z_mm = 0.0,
                                double from_rad = 0.0);

/// A controller on a clock that the test turns. `run` feeds the watchdog as a host would.
struct Rig {
    explicit Rig(ControllerOptions options = bar_options());

    /// Takes the next sequence, owner 7; the status right after.
    CommandStatus send(std::uint16_t opcode, std::initializer_list<std::int32_t> args = {}, std::uint32_t owner = 7);
    /// Turns the clock by milliseconds, one step each, feeding the watchdog.
    void run_ms(int milliseconds);
    /// Until the last command is no longer running; its status. Gives up after a minute of host time.
    CommandStatus finish();
    CommandStatus finish(std::uint16_t opcode, std::initializer_list<std::int32_t> args = {});
    /// Claims, homes, qualifies.
    void prepare();
    /// Sends the path in windows of ten, waiting where the controller is full.
    void upload(std::uint16_t id, const std::vector<PathPoint>& path);
    /// Begins the path, uploads it, SCAN with 1 mm approach and search and retract.
    void begin_scan(std::uint16_t id, const std::vector<PathPoint>& path);
    /// A whole scan.
    CommandStatus scan(std::uint16_t id, const std::vector<PathPoint>& path);
    std::vector<FifoSample> samples() const;

    core::ManualClock clock;
    std::vector<SampleTruth> truth;
    Controller controller;
    std::uint16_t seq = 0;
    std::uint16_t watchdog = 0;
};

void expect_failed(const CommandStatus& status, ResultCode result);

namespace opcode {
inline constexpr std::uint16_t claim = 1, release = 2, home = 3, qualify = 4, move = 5, touch = 6, scan = 7, stop = 8,
                               clear_fault = 9, path_begin = 10;
}

}  // namespace cmm::sim::test
