// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "drivers/link_stats.hpp"
#include "drivers/machine.hpp"
#include "drivers/modbus/conversation.hpp"

namespace cmm::drivers::modbus {

/// The wire to one controller: a blocking thread of its own around one link.
/// One job at a time, from one thread: connect() or run(), then done_fd() becomes readable, then the results may be
/// read. Does not retry and does not reconnect by itself, except to bring a stop to the wire. stop(), stats() and
/// set_trace() may be called from any thread at any time. A stop overtakes the transaction in flight; where the link
/// carries one request at a time, it is the next one, and the wait for the reply before it is cut short.
class Bus {
  public:
    /// Starts the thread; throws std::system_error when the system has no descriptors left.
    Bus(std::unique_ptr<Link> link, BusOptions options);
    /// Ends the thread, after a connect under way at the latest.
    ~Bus();
    Bus(const Bus&) = delete;
    Bus& operator=(const Bus&) = delete;

    /// Closes a link that is open, then opens a new one.
    void connect();
    /// Sends in order, up to `in_flight` ahead of their replies where the link lets requests overlap; after one that
    /// ended neither ok nor by an exception the rest stays `not_sent`. The array and its transactions must live until
    /// the job is done.
    void run(std::span<Transaction* const> batch, double response_timeout_ms, std::size_t in_flight = 1);
    /// An eventfd, non-blocking: reading 8 bytes from it takes the message that the job is done.
    int done_fd() const noexcept;

    /// Whether requests may overlap on this link, and how long so many bytes take on it.
    bool overlaps() const noexcept;
    double wire_ms(std::size_t bytes) const noexcept;
    /// How long the controller took for a request of the last batch in flight; 0: there was none.
    double service_ms() const noexcept;
    bool connected() const noexcept;
    /// Counts the connections made, those for a stop included.
    std::uint64_t link_number() const noexcept;
    /// Why the last connect failed; empty when it did not. Valid after its job is done.
    const std::string& connect_error() const noexcept;

    void stop(StopKind kind) noexcept;
    LinkStats stats() const;
    void count(const std::function<void(LinkStats&)>& change);
    void note(const std::string& text);
    void set_trace(std::function<void(std::string_view)> line);

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace cmm::drivers::modbus
