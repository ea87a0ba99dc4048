// SPDX-License-Identifier: Apache-2.0
// What a session's rounds are made of, and what becomes of the samples that they bring.
#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "drivers/controller/session.hpp"
#include "drivers/until_durable.hpp"

namespace cmm::drivers::controller {
namespace {

namespace asio = boost::asio;

constexpr double durable_patience_ms = std::chrono::duration<double, std::milli>(durable_patience).count();

}  // namespace

asio::awaitable<core::Result<FifoBlock>> Session::exchange(SampleSink* sink, PathFeed* feed, bool with_status) {
    const auto composed = compose(sink, feed, with_status);
    if (!composed) co_return tl::unexpected(composed.error());
    insist();
    auto answered = co_await port_->run(round_);
    if (answered && feed != nullptr) answered = feed->settle(round_);
    if (answered && sink != nullptr) answered = deliver(*sink);
    if (!answered) co_return tl::unexpected(answered.error());
    co_return summary(sink != nullptr);
}

/// Windows and blocks share what may be under way by the points that each of them carries: on a distant link as many
/// path points go out with a round as samples come back.
core::Status Session::compose(SampleSink* sink, PathFeed* feed, bool with_status) {
    const Reach reach = port_->reach();
    const std::size_t others = with_status ? 1 : 0;
    const std::size_t room = std::max<std::size_t>(reach.requests, 2 + others) - others;
    round_.command = nullptr;
    round_.windows.clear();
    if (feed != nullptr) {
        const std::size_t all = feed->window_points() + reach.block_samples;
        const std::size_t share = room * reach.block_samples / std::max<std::size_t>(all, 1);
        const std::size_t most = reach.requests > 1 ? std::clamp<std::size_t>(share, 1, room - 1) : 1;
        if (auto next = feed->next_windows(most, round_.windows); !next) return next;
    }
    if (sink != nullptr) reader_.durable(sink->durable_sequence());
    const std::size_t wanted = sink != nullptr && reach.requests > 1 ? blocks_worth_asking(reach) : 1;
    round_.blocks.resize(std::min(wanted, room - round_.windows.size()));
    std::uint32_t from = reader_.next_wanted();
    for (Round::BlockTurn& block : round_.blocks) {
        block.answered = false;
        block.acknowledge = reader_.acknowledge();
        block.from = from;
        from += static_cast<std::uint32_t>(reach.block_samples);
    }
    round_.ask_status = with_status;
    return {};
}

/// For the samples that are known to wait, and for as many new ones as came since the last round.
std::size_t Session::blocks_worth_asking(const Reach& reach) const {
    const std::int64_t waiting = std::int64_t{newest_} + 1 - std::int64_t{reader_.next_wanted()};
    const std::int64_t expected = std::max<std::int64_t>(waiting, 0) + newest_growth_;
    const auto each = static_cast<std::int64_t>(reach.block_samples);
    return static_cast<std::size_t>(std::max<std::int64_t>(1, (expected + each - 1) / each));
}

void Session::learn_newest(std::uint32_t newest) {
    newest_growth_ = newest > newest_ ? newest - newest_ : 0;
    newest_ = newest;
}

FifoBlock Session::summary(bool delivered) const {
    FifoBlock all;
    std::size_t count = 0;
    std::uint32_t newest = 0;
    for (const Round::BlockTurn& turn : round_.blocks) {
        if (!turn.answered) continue;
        newest = std::max(newest, turn.block.newest);
        count += turn.block.count;
        all = turn.block;
    }
    all.newest = newest;
    all.count = static_cast<std::uint16_t>(std::min<std::size_t>(count, 0xFFFF));
    if (!delivered) return all;
    all.set_more(newest >= reader_.next_wanted());
    return all;
}

asio::awaitable<core::Result<bool>> Session::send_windows(PathFeed& feed, std::uint32_t wanted) {
    const std::size_t windows = (wanted - feed.taken() + feed.window_points() - 1) / feed.window_points();
    round_ = Round{};
    const auto next = feed.next_windows(std::clamp<std::size_t>(windows, 1, port_->reach().requests), round_.windows);
    if (!next) co_return tl::unexpected(next.error());
    if (round_.windows.empty()) co_return false;
    auto answered = co_await port_->run(round_);
    if (answered) answered = feed.settle(round_);
    if (!answered) co_return tl::unexpected(answered.error());
    co_return true;
}

core::Status Session::deliver(SampleSink& sink) {
    const std::uint64_t duplicates = reader_.duplicates();
    std::uint32_t newest = 0;
    auto asked = SampleReader::Asked::due;
    for (Round::BlockTurn& turn : round_.blocks) {
        if (!turn.answered) continue;
        newest = std::max(newest, turn.block.newest);
        const auto fresh = reader_.take(turn.block, turn.samples, clock_.now().count(), asked);
        if (!fresh) return tl::unexpected(fresh.error());
        asked = SampleReader::Asked::ahead;
        if (fresh->empty()) continue;
        if (auto taken = sink.on_samples(*fresh); !taken) return taken;
    }
    learn_newest(newest);
    if (reader_.duplicates() != duplicates) {
        const std::uint64_t again = reader_.duplicates() - duplicates;
        port_->count([again](LinkStats& stats) { stats.duplicate_samples += again; });
    }
    return {};
}

asio::awaitable<core::Status> Session::drain(SampleSink& sink) {
    for (;;) {
        const auto block = co_await exchange(&sink, nullptr, false);
        if (!block) {
            const core::Error error = lost(block.error());
            co_return tl::unexpected(error);
        }
        if (!block->more() && block->newest < reader_.next_wanted()) co_return core::Status{};
        if (block->count == 0) {
            co_return core::fail(
                core::ErrorCode::protocol_invalid,
                "the controller holds samples up to " + std::to_string(block->newest) + " but does not send them");
        }
    }
}

asio::awaitable<core::Status> Session::settle(SampleSink& sink) {
    const double give_up_ms = port_->now_ms() + durable_patience_ms;
    for (;;) {
        const auto durable = sink.hasten();
        if (!durable) co_return tl::unexpected(durable.error());
        const auto block = co_await exchange(&sink, nullptr, false);
        if (!block) {
            const core::Error error = lost(block.error());
            co_return tl::unexpected(error);
        }
        if (*durable) co_return core::Status{};
        if (port_->now_ms() >= give_up_ms) co_return not_durable_in_time();
        co_await pause(poll_ms_);
    }
}
}  // namespace cmm::drivers::controller
