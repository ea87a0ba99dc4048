// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/sample.hpp"
#include "drivers/link_stats.hpp"
#include "drivers/machine.hpp"

/// What a host and a measuring controller say to each other, whatever the protocol: commands that are executed once per
/// sequence, windows of path points, samples with their acknowledgement, status. Each may be repeated without harm.
namespace cmm::drivers::controller {

enum class Opcode : std::uint16_t {
    claim = 1,
    release = 2,
    home = 3,
    qualify = 4,
    move = 5,
    touch = 6,
    scan = 7,
    clear_fault = 9,
    path_begin = 10,
};

/// What a result code means: text for people, error code for programs.
core::Error error_of_result(std::uint16_t result);

struct CommandBlock {
    std::uint16_t sequence = 0;
    Opcode opcode = Opcode::claim;
    std::uint32_t owner = 0;
    std::array<std::int32_t, 8> args{};
};

struct StatusBlock {
    std::uint16_t state = 0, heartbeat = 0, flags = 0, fault = 0, command_sequence = 0, command_state = 0, result = 0;
    std::array<std::int32_t, 4> values{};
    std::uint16_t path = 0;
    std::uint32_t path_passed = 0, path_received = 0, newest = 0, acknowledged = 0;
    std::array<std::int32_t, 3> position{};
    std::uint16_t fifo_level = 0;
    std::int64_t time_us = 0;
    std::uint32_t owner = 0;

    bool homed() const { return (flags & 1U) != 0; }
    bool qualified() const { return (flags & 2U) != 0; }
    bool in_contact() const { return (flags & 4U) != 0; }
    bool in_motion() const { return (flags & 8U) != 0; }
};

/// The head of a block of samples.
struct FifoBlock {
    std::uint16_t state = 0, path = 0, count = 0, flags = 0;
    std::uint32_t first = 0, newest = 0;  ///< controller sequence
    std::int64_t time_us = 0;

    bool overflow() const { return (flags & 1U) != 0; }
    bool more() const { return (flags & 2U) != 0; }
    bool path_ended() const { return (flags & 4U) != 0; }
    void set_more(bool more) { flags = static_cast<std::uint16_t>((flags & ~2U) | (more ? 2U : 0U)); }
};

/// Points of a path in a row.
struct Window {
    std::uint16_t path = 0;
    std::uint32_t first_index = 0;
    std::span<const PathPoint> points;
    bool last = false;
};

/// Whether a point can be sent as 32-bit counts, a unit normal and 16 bits of speed. Errors: plan_invalid.
core::Status check_point(const PathPoint& point, std::uint64_t index, double lsb_mm, double speed_step_mm_s);

/// One turn of the conversation: what is wanted, and what came of it. Carried out in the order of the members. Command,
/// status, first window and first block are repeated until they are answered; further windows and blocks are sent once:
/// what is not answered of them stays `not_asked`, and is asked for again in a round of its own.
struct Round {
    enum class Fate : std::uint8_t { not_asked, done, busy, refused };

    struct WindowTurn {
        Window window;
        Fate fate = Fate::not_asked;
    };
    struct BlockTurn {
        std::uint32_t acknowledge = 0;  ///< safe at the host up to here
        std::uint32_t from = 1;         ///< first sample to send
        bool answered = false;
        FifoBlock block;
        std::vector<core::Sample> samples;  ///< of the block; controller sequences, host time 0
    };

    const CommandBlock* command = nullptr;
    std::vector<WindowTurn> windows;
    std::vector<BlockTurn> blocks;
    bool ask_status = false;

    Fate command_fate = Fate::not_asked;
    std::string refusal;  ///< what the controller said to the first of command, windows or blocks that it refused
    StatusBlock status;
};

/// How far a round may go: more than one window or block is sent ahead of the replies, on links that allow it.
struct Reach {
    std::size_t requests = 1;       ///< under way at once; 1: each waits for the reply before it
    std::size_t block_samples = 1;  ///< of one block
};

/// A protocol's way to one controller. Coroutines are awaited on the machine's executor; rounds of several users are
/// carried out one after another.
class Port {
  public:
    Port() = default;
    virtual ~Port() = default;
    Port(const Port&) = delete;
    Port& operator=(const Port&) = delete;

    /// One attempt to connect and to ask who is there. Errors: transport_*, protocol_*.
    virtual boost::asio::awaitable<core::Result<Capabilities>> open() = 0;
    /// Repeats what is not answered, over a fresh link if need be, as long as the settings say. Refusals of command and
    /// window are no errors. Errors: transport_*, protocol_invalid (also: the exchange is refused), machine_fault: the
    /// controller was restarted.
    virtual boost::asio::awaitable<core::Status> run(Round& round) = 0;
    virtual boost::asio::awaitable<void> pause(double ms) = 0;

    /// Points that fit into one window, whatever the controller says.
    virtual std::size_t window_limit() const noexcept = 0;
    /// At present: a controller may turn out not to take what a link would carry.
    virtual Reach reach() const noexcept { return {}; }
    /// Errors: plan_invalid when the protocol has no number for a value (position, normal, speed).
    virtual core::Status check_point(const PathPoint& point, std::uint64_t index, double lsb_mm) const = 0;
    /// The path points passed, from a counter that may go round; `near` is a number not far from it.
    virtual std::uint32_t unwrapped_passed(std::uint32_t value, std::uint32_t near) const noexcept = 0;
    /// How often the status is worth its time on the line while a path is scanned.
    virtual double status_every_ms() const noexcept = 0;

    virtual bool opened() const noexcept = 0;
    virtual double now_ms() const noexcept = 0;
    /// When the controller last answered, in the time of now_ms().
    virtual double last_answer_ms() const noexcept = 0;

    /// Any thread, any time; overtakes what is under way as far as the protocol lets it.
    virtual void stop(StopKind kind) noexcept = 0;
    virtual LinkStats stats() const = 0;
    virtual void count(const std::function<void(LinkStats&)>& change) = 0;
    virtual void set_trace(std::function<void(std::string_view)> line) = 0;
};

}  // namespace cmm::drivers::controller
