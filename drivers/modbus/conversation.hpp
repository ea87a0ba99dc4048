// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/event_fd.hpp"
#include "drivers/link_log.hpp"
#include "drivers/machine.hpp"
#include "drivers/modbus/frame.hpp"
#include "drivers/modbus/link.hpp"

namespace cmm::drivers::modbus {

struct BusOptions {
    std::uint16_t stop_address = 200;
    double connect_timeout_ms = 2000.0;
    double stop_timeout_ms = 500.0;  ///< for the reply to a stop
};

/// Requests, replies and stops over one link, blocking. One thread, but for want_stop(), quit(), wake() and what is
/// read from atomics. Neither retries nor reconnects by itself, except to bring a stop to the wire.
class Conversation {
  public:
    Conversation(std::unique_ptr<Link> link, BusOptions options) : options_(options), link_(std::move(link)) {}

    /// Closes a link that is open, then opens a new one; from then on there is somebody to stop.
    void connect();
    /// Sends in order, up to `in_flight` ahead of their replies where the link lets requests overlap; `timeout_ms` is
    /// the longest time without a reply. After one that ended neither ok nor by an exception the rest stays `not_sent`.
    void run(std::span<Transaction* const> batch, double timeout_ms, std::size_t in_flight);
    /// Sends a stop that is wanted and sees to it that it is answered: over a fresh link if the present one does not
    /// carry it. A few attempts are enough: a controller that cannot be reached stops by its watchdog.
    void serve_stop();

    void want_stop(StopKind kind) noexcept;
    /// Whatever is waited for is given up, for good.
    void quit() noexcept;
    bool quits() const noexcept { return quit_; }
    /// Readable when another thread wants something.
    EventFd& wake() noexcept { return wake_; }
    LinkLog& log() noexcept { return log_; }

    const Link& link() const noexcept { return *link_; }
    bool connected() const noexcept { return connected_; }
    std::uint64_t link_number() const noexcept { return link_number_; }
    const std::string& connect_error() const noexcept { return connect_error_; }
    /// How long the controller took for a request of the last batch in flight, by the time between its replies; 0:
    /// there was none.
    double service_ms() const noexcept { return service_ms_; }

  private:
    using TimePoint = std::chrono::steady_clock::time_point;
    using Duration = std::chrono::steady_clock::duration;
    /// A request that is under way.
    struct Flight {
        std::uint16_t id = 0;
        Transaction* transaction = nullptr;
        TimePoint sent;
    };

    void open_link();
    void close_link();
    void execute(std::span<Transaction* const> group, double timeout_ms);
    bool take_off(std::span<Transaction* const> group);
    bool send(const Transaction& transaction, std::uint16_t id, bool more = false);
    void await_replies(Duration patience);
    bool wait_for_link(TimePoint deadline);
    bool take(const Arrival& arrival);
    bool land(std::vector<Flight>::iterator flight, std::span<const std::uint8_t> pdu);
    void give_up(Transaction::Outcome outcome);
    void note_service(TimePoint first_reply, TimePoint last_reply, std::size_t replies);
    void recover(std::span<Transaction* const> group, Duration patience);
    void let_late_reply_pass();
    void send_stop();
    void take_stop();
    void await_stop();
    Transaction stop_transaction() const;
    void record(Transaction::Outcome outcome, double us);
    double wire_ms(const Transaction& transaction) const;

    BusOptions options_;
    std::unique_ptr<Link> link_;
    EventFd wake_;
    LinkLog log_;
    std::atomic<bool> connected_{false}, quit_{false};
    std::atomic<std::uint64_t> link_number_{0};
    std::string connect_error_;
    std::uint16_t last_id_ = 0;
    std::vector<Flight> under_way_;
    std::atomic<double> service_ms_{0.0};
    bool rest_is_missing_ = false;     // of a reply that has begun to arrive
    TimePoint late_until_{};           // a reply that was given up may still come
    bool stop_matters_ = false;        // before the first connect there is nobody to stop
    std::atomic<int> stop_wanted_{0};  // 0, 1 controlled, 2 emergency
    std::atomic<std::int64_t> stop_requested_ns_{0};
    int stop_owed_ = 0;  // like stop_wanted_: taken from there, not yet answered
    std::uint16_t stop_id_ = 0;
    bool stop_sent_ = false;  // over the present link, not yet answered
};

}  // namespace cmm::drivers::modbus
