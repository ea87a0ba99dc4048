// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
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

    /// The next windows, `most` of them at most; none when there is nothing to send now. A source that does not fill a
    /// window follows the samples: then there is no second one. The windows live until settle(); ask again after it.
    /// Errors: plan_invalid (a point that the protocol has no number for).
    core::Status next_windows(std::size_t most, std::vector<Round::WindowTurn>& windows);
    /// What became of the windows given last. Errors: protocol_invalid (the first is refused for another reason than
    /// busy; those behind it may be refused only because it was not taken).
    core::Status settle(const Round& round);
    /// At least so many points lie behind the probe.
    void passed(std::uint32_t points) noexcept;

    /// Points of a full window.
    std::size_t window_points() const noexcept { return window_points_; }
    std::uint32_t behind_probe() const noexcept { return passed_; }
    std::uint32_t taken() const noexcept { return taken_; }
    /// Whether the controller has points for so many more rounds in which the probe passes so many.
    bool lasts(std::uint32_t rounds, std::uint32_t points_a_round) const noexcept {
        return taken_ - passed_ >= rounds * std::max<std::uint32_t>(points_a_round, 1);
    }
    /// Every point is with the controller.
    bool complete() const noexcept { return ended_ && pending_.empty(); }
    /// A window was refused as busy: it is offered again after progress, or after try_again().
    bool refused() const noexcept { return refused_; }
    void try_again() noexcept { refused_ = false; }

  private:
    /// Points of a window that is not yet taken.
    struct Pending {
        std::uint32_t first_index = 0;
        std::vector<PathPoint> points;
        bool last = false;
    };
    bool may_fill(std::size_t most) const noexcept;
    core::Result<bool> fill();
    std::uint32_t given() const noexcept;

    const Port& port_;
    double lsb_mm_;
    std::size_t capacity_;
    std::uint16_t path_;
    PathSource& source_;
    std::size_t window_points_;
    std::deque<Pending> pending_;
    bool ended_ = false;     // a window, pending or taken, holds the last point
    bool refused_ = false;   // busy since the last progress
    bool was_busy_ = false;  // since the last window that was taken: the next goes alone
    std::uint32_t taken_ = 0;
    std::uint32_t passed_ = 0;
    PathPoint last_point_;  // of the source, for an end that it notices late
};

}  // namespace cmm::drivers::controller
