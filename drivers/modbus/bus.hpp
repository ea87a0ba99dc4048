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
#include "drivers/modbus/frame.hpp"

namespace cmm::drivers::modbus {

struct BusOptions {
    std::string host;
    std::uint16_t port = 502;
    std::uint8_t unit = 1;
    std::uint16_t stop_address = 200;
    double connect_timeout_ms = 2000.0;
    double stop_timeout_ms = 500.0;  ///< for the reply to a stop
};

/// The wire to one controller: a blocking thread of its own around one libmodbus context.
/// One job at a time, from one thread: connect() or run(), then done_fd() becomes readable, then the results may be
/// read. Does not retry and does not reconnect by itself, except to bring a stop to the wire. stop(), stats() and
/// set_trace() may be called from any thread at any time; a stop overtakes the transaction in flight.
class Bus {
  public:
    /// Starts the thread; throws std::system_error when the system has no descriptors left.
    explicit Bus(BusOptions options);
    /// Ends the thread, after a connect under way at the latest.
    ~Bus();
    Bus(const Bus&) = delete;
    Bus& operator=(const Bus&) = delete;

    /// Closes a link that is open, then opens a new one.
    void connect();
    /// Executes in order; after one that ended neither ok nor by an exception the rest stays `not_sent`.
    /// The array and its transactions must live until the job is done.
    void run(std::span<Transaction* const> batch, double response_timeout_ms);
    /// An eventfd, non-blocking: reading 8 bytes from it takes the message that the job is done.
    int done_fd() const noexcept;

    bool connected() const noexcept;
    /// Counts the connections made, those for a stop included.
    std::uint64_t link_number() const noexcept;
    /// Why the last connect failed; empty when it did not. Valid after its job is done.
    const std::string& connect_error() const noexcept;

    void stop(StopKind kind) noexcept;
    LinkStats stats() const;
    void count(const std::function<void(LinkStats&)>& change);
    void set_trace(std::function<void(std::string_view)> line);

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace cmm::drivers::modbus
