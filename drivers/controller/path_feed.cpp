// SPDX-License-Identifier: Apache-2.0
#include "drivers/controller/path_feed.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace cmm::drivers::controller {

PathFeed::PathFeed(const Port& port, const Capabilities& machine, std::uint16_t path, PathSource& source)
    : port_(port),
      lsb_mm_(machine.lsb_mm),
      capacity_(machine.path_capacity),
      path_(path),
      source_(source),
      window_points_(std::min(machine.path_window, port.window_limit())) {}

/// Points that the source has given.
std::uint32_t PathFeed::given() const noexcept {
    if (pending_.empty()) return taken_;
    return pending_.back().first_index + static_cast<std::uint32_t>(pending_.back().points.size());
}

bool PathFeed::may_fill(std::size_t most) const noexcept {
    if (ended_ || pending_.size() >= most) return false;
    if (pending_.empty()) return true;
    const bool room = given() - passed_ + window_points_ <= capacity_;
    return room && pending_.back().points.size() == window_points_;
}

core::Status PathFeed::next_windows(std::size_t most, std::vector<Round::WindowTurn>& windows) {
    windows.clear();
    while (may_fill(most)) {
        const auto filled = fill();
        if (!filled) return tl::unexpected(filled.error());
        if (!*filled) break;
    }
    if (refused_) return {};
    for (const Pending& next : pending_) {
        const std::size_t ahead = next.first_index - passed_ + next.points.size();
        const std::size_t worth_trying = was_busy_ ? 1 : most;
        if (windows.size() == worth_trying || ahead > capacity_) break;
        windows.push_back({Window{path_, next.first_index, next.points, next.last}, Round::Fate::not_asked});
    }
    return {};
}

/// False: the source has nothing now.
core::Result<bool> PathFeed::fill() {
    Pending next;
    next.first_index = given();
    next.points.resize(window_points_);
    const std::size_t count = source_.next(next.points, next.last);
    next.points.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
        const std::uint64_t index = std::uint64_t{next.first_index} + k;
        if (auto fits = port_.check_point(next.points[k], index, lsb_mm_); !fits) return tl::unexpected(fits.error());
    }
    // The end of a path is a flag of its last point. A source that notices the end only afterwards gets that point once
    // more, unrecorded.
    if (next.last && count == 0) {
        if (next.first_index == 0) return core::fail(core::ErrorCode::plan_invalid, "the path has no points");
        next.points.assign(1, last_point_);
        next.points.front().record = false;
    }
    if (next.points.empty()) return false;
    ended_ = next.last;
    last_point_ = next.points.back();
    pending_.push_back(std::move(next));
    return true;
}

core::Status PathFeed::settle(const Round& round) {
    for (std::size_t k = 0; k < round.windows.size(); ++k) {
        const Round::Fate fate = round.windows[k].fate;
        if (fate == Round::Fate::done) {
            taken_ += static_cast<std::uint32_t>(pending_.front().points.size());
            pending_.pop_front();
            was_busy_ = false;
            continue;
        }
        if (fate == Round::Fate::busy) refused_ = was_busy_ = true;
        if (fate != Round::Fate::refused || k > 0) return {};
        return core::fail(core::ErrorCode::protocol_invalid, "the controller refuses path points from " +
                                                                 std::to_string(taken_) + " on with " + round.refusal);
    }
    return {};
}

void PathFeed::passed(std::uint32_t points) noexcept {
    if (points <= passed_) return;
    passed_ = points;
    refused_ = false;
}

}  // namespace cmm::drivers::controller
