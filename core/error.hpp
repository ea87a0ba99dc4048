// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace cmm::core {

/// What went wrong, by the layer that can do something about it. Text, advice and exit code hang on the code alone.
enum class ErrorCode : std::uint8_t {
    usage,                ///< the command line is wrong
    config_syntax,        ///< a configuration file does not parse
    config_invalid,       ///< it parses, a value or key in it does not hold
    input_missing,        ///< a file is not there or not readable
    input_invalid,        ///< a points, mesh or section file is broken
    plan_invalid,         ///< the plan check refuses the path
    fit_not_evaluable,    ///< the points do not determine the result
    transport_connect,    ///< nobody answers at the endpoint
    transport_timeout,    ///< a reply did not come in time
    transport_closed,     ///< the link broke
    protocol_mismatch,    ///< the peer is not what we expect (identity, map version)
    protocol_invalid,     ///< a reply makes no sense (length, CRC, sequence)
    machine_busy,         ///< a motion is under way; a second one is refused, never queued
    machine_refused,      ///< the controller refuses the command in its present state
    machine_fault,        ///< the controller stopped with a fault
    machine_no_contact,   ///< nothing was there to touch, or the surface was lost
    machine_overflow,     ///< its sample FIFO ran full; the path ended
    machine_watchdog,     ///< it stopped because it did not hear from us
    machine_emergency,    ///< the emergency stop is pressed
    machine_limit,        ///< a position lies outside the travel
    machine_door,         ///< a door or light curtain is open
    machine_temperature,  ///< too warm or too cold to measure
    machine_deflection,   ///< the probe was bent too far
    machine_position,     ///< it does not know its position any more
    journal_io,           ///< the run file cannot be written or read
    journal_full,         ///< the disk is full
    journal_slow,         ///< the disk is too slow for what is measured
    journal_corrupt,      ///< the run file does not hold what it must
    cancelled,            ///< stopped on request
    internal,             ///< a broken invariant of ours
};

/// What is known about the machine's motion when an operation ends with an error.
enum class Motion : std::uint8_t { stopped, may_be_moving, unknown, not_concerned };

std::string_view to_string(ErrorCode code) noexcept;
std::string_view to_string(Motion motion) noexcept;
/// One line for the user: what to do about an error of this kind.
std::string_view advice(ErrorCode code) noexcept;
/// Whether repeating the same exchange can help (idempotent exchanges only).
bool retryable(ErrorCode code) noexcept;
/// The process exit code of the command-line contract (3 input, 4 machine, 5 link, 6 storage, 70 internal).
int exit_code(ErrorCode code) noexcept;

/// A failure as a value: the code, what happened, and the chain of places it passed (innermost first).
struct Error {
    ErrorCode code = ErrorCode::internal;
    std::string message;               ///< what and where: "blade.csv:17:3: z is not a number: 'abc'"
    std::vector<std::string> context;  ///< appended on the way up: "while scanning path 4"
    Motion motion = Motion::not_concerned;

    Error& with_context(std::string where) &;
    Error&& with_context(std::string where) &&;
    /// "message (while ...)": one line, without the advice.
    std::string text() const;
};

template <class T>
using Result = tl::expected<T, Error>;
using Status = Result<void>;

/// The short way to fail: `return fail(ErrorCode::input_invalid, "...")`.
tl::unexpected<Error> fail(ErrorCode code, std::string message, Motion motion = Motion::not_concerned);

}  // namespace cmm::core
