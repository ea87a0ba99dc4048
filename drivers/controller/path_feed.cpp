// SPDX-License-Identifier: Apache-2.0
#include "drivers/controller/path_feed.hpp"

#include <algorithm>
#include <string>

namespace cmm::drivers::controller {

PathFeed::PathFeed(const Port& port, const Capabilities& machine, std::uint16_t path, PathSource& source)
    : port_(port),
      lsb_mm_(machine.lsb_mm),
      capacity_(machine.path_capacity),
      path_(path),
      source_(source),
      points_(std::min(machine.path_window, port.window_limit())) {}

core::Result<const Window*> PathFeed::next_window() {
    if (pending_ == 0 && !ended_) {
        if (auto filled = fill(); !filled) return tl::unexpected(filled.error());
    }
    const bool room = taken_ - passed_ + pending_ <= capacity_;
    if (pending_ == 0 || refused_ || !room) return static_cast<const Window*>(nullptr);
    return &window_;
}

core::Status PathFeed::fill() {
    bool last = false;
    pending_ = source_.next(points_, last);
    for (std::size_t k = 0; k < pending_; ++k) {
        if (auto fits = port_.check_point(points_[k], std::uint64_t{taken_} + k, lsb_mm_); !fits) return fits;
    }
    if (last && pending_ == 0) {
        if (auto marked = add_end_mark(); !marked) return marked;
    }
    if (pending_ == 0) return {};
    ended_ = last;
    last_point_ = points_[pending_ - 1];
    window_ = {path_, taken_, std::span(points_).first(pending_), last};
    return {};
}

/// The end of a path is a flag of its last point. A source that notices the end only afterwards gets that point once
/// more, unrecorded.
core::Status PathFeed::add_end_mark() {
    if (taken_ == 0) return core::fail(core::ErrorCode::plan_invalid, "the path has no points");
    points_[0] = last_point_;
    points_[0].record = false;
    pending_ = 1;
    return {};
}

core::Status PathFeed::settle(const Round& round) {
    if (round.window_fate == Round::Fate::done) {
        taken_ += static_cast<std::uint32_t>(pending_);
        pending_ = 0;
        return {};
    }
    if (round.window_fate == Round::Fate::busy) {
        refused_ = true;
        return {};
    }
    return core::fail(core::ErrorCode::protocol_invalid, "the controller refuses path points from " +
                                                             std::to_string(taken_) + " on with " + round.refusal);
}

void PathFeed::passed(std::uint32_t points) noexcept {
    if (points <= passed_) return;
    passed_ = points;
    refused_ = false;
}

}  // namespace cmm::drivers::controller
