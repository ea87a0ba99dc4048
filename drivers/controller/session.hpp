// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <memory>
#include <optional>

#include "drivers/controller/path_feed.hpp"
#include "drivers/controller/port.hpp"
#include "drivers/controller/sample_reader.hpp"
#include "drivers/registry.hpp"

namespace cmm::drivers::controller {

/// StatusBlock::command_state of a command under way.
inline constexpr std::uint16_t command_running = 1;

/// The protocol's conversations with one controller: ownership, commands and their fate, samples and their
/// acknowledgement. What a motion consists of is the machine's business. Used on one executor, by one operation at a
/// time but for status(). Errors carry what is known about the motion.
class Session {
  public:
    Session(std::unique_ptr<Port> port, double poll_ms, const DriverContext& context);

    boost::asio::awaitable<core::Result<Capabilities>> open();
    boost::asio::awaitable<core::Result<RunOrigin>> begin(std::optional<RunOrigin> resume);
    boost::asio::awaitable<core::Status> release();

    boost::asio::awaitable<core::Result<StatusBlock>> status();
    /// Ready for a command: connected, run begun, nothing moving, ours.
    boost::asio::awaitable<core::Status> prepare();
    /// Gives a command (after prepare()) and returns the status that shows it taken. Errors: the controller's refusal.
    boost::asio::awaitable<core::Result<StatusBlock>> give(Opcode opcode, std::array<std::int32_t, 8> args);
    /// Sends path points, as many windows as may be under way, to get `wanted` points to the controller in all. Returns
    /// whether there were any to send. Errors: those of the round and of the feed.
    boost::asio::awaitable<core::Result<bool>> send_windows(PathFeed& feed, std::uint32_t wanted);
    /// Keeps the exchange going until the command given last has ended; samples go to the sink, if there is one.
    boost::asio::awaitable<core::Result<StatusBlock>> finish(StatusBlock status, SampleSink* sink);
    /// One round: path windows, blocks of samples, a status after them when wanted; new samples go to the sink. Returns
    /// the head of the last block, with the count and the newest number of all.
    boost::asio::awaitable<core::Result<FifoBlock>> exchange(SampleSink* sink, PathFeed* feed, bool with_status);
    /// Between these the machine moves by our command (for the Error::motion of a lost link).
    void begin_motion() noexcept { moving_ = true; }
    void end_motion() noexcept { moving_ = false; }
    /// Whether the command given last is the one the status tells of.
    bool is_ours(const StatusBlock& status) const noexcept { return status.command_sequence == command_sequence_; }
    /// The status of the last exchange that had one.
    const StatusBlock& latest_status() const noexcept { return round_.status; }
    /// Delivers everything the controller holds.
    boost::asio::awaitable<core::Status> drain(SampleSink& sink);
    /// Waits until everything delivered is durable and acknowledged.
    boost::asio::awaitable<core::Status> settle(SampleSink& sink);
    /// After an error in a motion: stops the machine if it can be reached, and completes the error.
    boost::asio::awaitable<core::Error> abandon(core::Error error);
    /// Any thread. A motion under way is told again and again until it ends: also a stop may get lost.
    void stop(StopKind kind) noexcept;
    /// The failure of a command that has ended, or nothing.
    static std::optional<core::Error> failure(const StatusBlock& status);

    boost::asio::awaitable<void> pause(double ms);
    const Capabilities& capabilities() const noexcept { return capabilities_; }
    const SampleReader& reader() const noexcept { return reader_; }
    std::uint32_t owner() const noexcept { return owner_; }
    Port& port() noexcept { return *port_; }
    const Port& port() const noexcept { return *port_; }
    double poll_ms() const noexcept { return poll_ms_; }

  private:
    boost::asio::awaitable<core::Status> claim(double patience_ms);
    core::Status compose(SampleSink* sink, PathFeed* feed, bool with_status);
    std::size_t blocks_worth_asking(const Reach& reach) const;
    void learn_newest(std::uint32_t newest);
    core::Status deliver(SampleSink& sink);
    FifoBlock summary(bool delivered) const;
    core::Error lost(core::Error error) const;
    void insist();
    core::Result<RunOrigin> take_up(const StatusBlock& status, const std::optional<RunOrigin>& resume);

    std::unique_ptr<Port> port_;
    const core::Clock& clock_;
    double poll_ms_;
    std::uint32_t owner_;
    std::uint16_t command_sequence_ = 0;
    bool begun_ = false;
    bool moving_ = false;             // a motion command of ours is under way
    std::atomic<int> stop_asked_{0};  // 1 controlled, 2 emergency: since the last command
    double insist_at_ms_ = 0.0;       // 0: not seen yet
    Capabilities capabilities_;
    SampleReader reader_;
    CommandBlock command_;
    Round round_;                      // of the operation under way; status() has its own
    std::uint32_t newest_ = 0;         // sample of the controller that we know of
    std::uint32_t newest_growth_ = 0;  // by the last round
};

}  // namespace cmm::drivers::controller
