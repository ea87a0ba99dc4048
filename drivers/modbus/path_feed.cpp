// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/path_feed.hpp"

#include <string>

#include "drivers/modbus/blocks.hpp"

namespace cmm::drivers::modbus {

PathFeed::PathFeed(const RegisterMap& map, const Capabilities& machine, std::uint16_t path, PathSource& source)
    : map_(map),
      lsb_mm_(machine.lsb_mm),
      capacity_(machine.path_capacity),
      path_(path),
      source_(source),
      window_(machine.path_window) {
    transaction_.kind = Transaction::Kind::write;
    transaction_.write_address = map.path.address;
}

core::Result<Transaction*> PathFeed::next_window() {
    if (pending_ == 0 && !ended_) {
        if (auto filled = fill(); !filled) return tl::unexpected(filled.error());
    }
    const bool room = taken_ - passed_ + pending_ <= capacity_;
    if (pending_ == 0 || refused_ || !room) return nullptr;
    return &transaction_;
}

core::Status PathFeed::fill() {
    bool last = false;
    pending_ = source_.next(window_, last);
    for (std::size_t k = 0; k < pending_; ++k) {
        if (auto fits = check_point(map_, window_[k], std::uint64_t{taken_} + k, lsb_mm_); !fits) return fits;
    }
    if (last && pending_ == 0) {
        if (auto marked = add_end_mark(); !marked) return marked;
    }
    if (pending_ == 0) return {};
    ended_ = last;
    last_point_ = window_[pending_ - 1];
    transaction_.write_count = static_cast<std::uint16_t>(
        encode_window(map_, path_, taken_, std::span(window_).first(pending_), last, lsb_mm_, transaction_.written));
    return {};
}

/// The end of a path is a flag of its last point. A source that notices the end only afterwards gets that point once
/// more, unrecorded.
core::Status PathFeed::add_end_mark() {
    if (taken_ == 0) return core::fail(core::ErrorCode::plan_invalid, "the path has no points");
    window_[0] = last_point_;
    window_[0].record = false;
    pending_ = 1;
    return {};
}

core::Status PathFeed::settle() {
    if (transaction_.outcome == Transaction::Outcome::ok) {
        taken_ += static_cast<std::uint32_t>(pending_);
        pending_ = 0;
        return {};
    }
    if (transaction_.exception == exception_code::busy) {
        refused_ = true;
        return {};
    }
    return core::fail(core::ErrorCode::protocol_invalid, "the controller refuses path points from " +
                                                             std::to_string(taken_) + " on with exception " +
                                                             std::to_string(transaction_.exception));
}

void PathFeed::passed(std::uint32_t points) noexcept {
    if (points <= passed_) return;
    passed_ = points;
    refused_ = false;
}

}  // namespace cmm::drivers::modbus
