// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/controller/port.hpp"

namespace cmm::drivers::controller {

/// Cuts a path into windows and keeps account of what the controller has taken, so that it is always fed but never
/// overfed. A window that was refused as busy, or whose reply was lost, is offered again unchanged. No I/O; not
/// thread-safe.
class PathFeed {
  public:
    PathFeed(const Port& port, const Capabilities& machine, std::uint16_t path, PathSource& source);

    /// The next window, or null when there is nothing to send now. Ask again only after settle().
    /// Errors: plan_invalid (a point that the protocol has no number for).
    core::Result<const Window*> next_window();
    /// What became of the window sent last. Errors: protocol_invalid (refused for another reason than busy).
    core::Status settle(const Round& round);
    /// At least so many points lie behind the probe.
    void passed(std::uint32_t points) noexcept;

    std::uint32_t behind_probe() const noexcept { return passed_; }
    std::uint32_t taken() const noexcept { return taken_; }
    /// Every point is with the controller.
    bool complete() const noexcept { return ended_ && pending_ == 0; }
    /// A window was refused as busy: it is offered again after progress, or after try_again().
    bool refused() const noexcept { return refused_; }
    void try_again() noexcept { refused_ = false; }

  private:
    core::Status fill();
    core::Status add_end_mark();

    const Port& port_;
    double lsb_mm_;
    std::size_t capacity_;
    std::uint16_t path_;
    PathSource& source_;
    std::vector<PathPoint> points_;
    std::size_t pending_ = 0;  // points in the window, not yet taken
    bool ended_ = false;       // the window (or one before it) holds the last point
    bool refused_ = false;     // busy since the last progress
    std::uint32_t taken_ = 0;
    std::uint32_t passed_ = 0;
    PathPoint last_point_;  // of the source, for an end that it notices late
    Window window_;
};

}  // namespace cmm::drivers::controller
