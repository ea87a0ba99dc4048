// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace cmm::sim {

/// What may break, on the machine or on the way to it (docs/reliability.md says what each is). In the order of the
/// table in fault_plan.cpp.
enum class FaultKind : std::uint8_t {
    emergency_stop,
    door,
    temperature,
    over_deflection,
    collision,
    travel_limit,
    encoder_jump,
    fifo_overflow,
    clock_jump,
    drift,
    lift_off,
    dirt,
    part_shift,
    restart,
    hang,
    exception,
    delay,
    lost_request,
    lost_reply,
    bad_crc,
    split,
    merged,
    duplicated,
    stale,
    truncated,
    reordered,
    wrong_unit,
    closed,
    half_open,
    cable,
    dropped_bytes,
    flipped_bytes,
    overrun
};
std::string_view to_string(FaultKind kind) noexcept;
/// Whether it happens to the messages rather than to the machine.
bool on_the_wire(FaultKind kind) noexcept;

/// When a fault strikes: at a number drawn from here to there.
struct FaultTime {
    enum class Count : std::uint8_t { samples, requests, seconds };
    Count count = Count::samples;
    double from = 0.0, to = 0.0;
};

struct Fault {
    FaultKind kind = FaultKind::emergency_stop;
    FaultTime when;
    bool again = false;   ///< drawn anew, counted on, after each strike
    double amount = 0.0;  ///< its unit belongs to the kind
    double for_s = 0.0;   ///< how long it lasts, wall time; 0: for good
    int times = 1;        ///< messages or points in a row
};

struct FaultPlan {
    std::optional<std::uint64_t> seed;  ///< of the numbers drawn; absent: that of the simulator
    std::vector<Fault> faults;
};

/// Reads [[fault]] tables. Errors: input_missing, config_syntax, config_invalid, each with file, line and column.
core::Result<FaultPlan> load_fault_plan(const std::string& file);

}  // namespace cmm::sim
