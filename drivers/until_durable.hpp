// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <string>

#include "core/error.hpp"

namespace cmm::drivers {

constexpr auto durable_patience = std::chrono::seconds(30);  // a slow disk, not a dead one

/// What is said when the patience is over.
inline tl::unexpected<core::Error> not_durable_in_time() {
    return core::fail(core::ErrorCode::journal_slow, "the disk did not take what was measured within " +
                                                         std::to_string(durable_patience.count()) + " s");
}

/// Waits, without holding up the executor, until a SampleSink or a journal has on the disk all that it was given.
/// Errors: what the disk failed with; journal_slow.
template <class Keeper>
boost::asio::awaitable<core::Status> until_durable(Keeper& keeper) {
    boost::asio::steady_timer pause(co_await boost::asio::this_coro::executor);
    const auto give_up = std::chrono::steady_clock::now() + durable_patience;
    while (true) {
        const auto durable = keeper.hasten();
        if (!durable) co_return tl::unexpected(durable.error());
        if (*durable) co_return core::Status{};
        if (std::chrono::steady_clock::now() >= give_up) co_return not_durable_in_time();
        pause.expires_after(std::chrono::milliseconds(1));
        co_await pause.async_wait(boost::asio::use_awaitable);
    }
}

}  // namespace cmm::drivers
