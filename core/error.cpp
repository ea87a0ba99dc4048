// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"

#include <array>
#include <utility>

namespace cmm::core {
namespace {

struct CodeFacts {
    ErrorCode code;
    std::string_view name;
    std::string_view advice;
    int exit_code;
    bool retryable;
};

constexpr std::array facts{
    CodeFacts{ErrorCode::usage, "usage", "Run the command with --help to see its options.", 3, false},
    CodeFacts{ErrorCode::config_syntax, "config_syntax",
              "Mend the file at the place named; `cmmlive config check FILE` tells whether it is right.", 3, false},
    CodeFacts{ErrorCode::config_invalid, "config_invalid",
              "Correct the value; `cmmlive config explain` lists every key with its unit and range.", 3, false},
    CodeFacts{ErrorCode::input_missing, "input_missing",
              "Check the name; relative names are taken from the file that names them.", 3, false},
    CodeFacts{ErrorCode::input_invalid, "input_invalid",
              "Correct the file at the place named; points are x,y,z[,section[,flag]] in mm.", 3, false},
    CodeFacts{
        ErrorCode::plan_invalid, "plan_invalid",
        "Change heights, clearance, stylus or the machine's limits; `cmmlive plan` shows the check without moving.", 3,
        false},
    CodeFacts{ErrorCode::fit_not_evaluable, "fit_not_evaluable",
              "Measure more points on the part named, or close the section.", 3, false},
    CodeFacts{ErrorCode::transport_connect, "transport_connect",
              "Check that the controller is on, the address and port are right, and no firewall is between; `cmmlive "
              "doctor --machine` tries it.",
              5, true},
    CodeFacts{ErrorCode::transport_timeout, "transport_timeout",
              "Check cable and load of the link; if the machine runs on, press its stop button. Then run again with "
              "--resume.",
              5, true},
    CodeFacts{ErrorCode::transport_closed, "transport_closed",
              "Restore the link, then run the same command with --resume: nothing measured is lost.", 5, true},
    CodeFacts{ErrorCode::protocol_mismatch, "protocol_mismatch",
              "Use the register map that belongs to this controller (key `map` in the machine file).", 5, false},
    CodeFacts{ErrorCode::protocol_invalid, "protocol_invalid",
              "If it comes again, record a trace and compare it with docs/protocol-modbus.md.", 5, true},
    CodeFacts{ErrorCode::machine_busy, "machine_busy", "Wait for the present motion to end, or stop it.", 4, false},
    CodeFacts{ErrorCode::machine_refused, "machine_refused",
              "Home and qualify first; look at the controller's state with `cmmlive doctor --machine`.", 4, false},
    CodeFacts{ErrorCode::machine_fault, "machine_fault",
              "Look at the machine, clear the cause, then run the same command with --resume.", 4, false},
    CodeFacts{ErrorCode::machine_no_contact, "machine_no_contact",
              "Check that the part lies where the part file says ([scan] search_mm, start_mm, toward_mm, heights), "
              "then --resume.",
              4, false},
    CodeFacts{ErrorCode::machine_overflow, "machine_overflow",
              "The host was too slow for the sample rate: lower the speed or widen the pitch, then --resume.", 4,
              false},
    CodeFacts{ErrorCode::machine_watchdog, "machine_watchdog",
              "The controller lost contact with this program and stopped. Run the same command with --resume.", 4,
              false},
    CodeFacts{ErrorCode::machine_emergency, "machine_emergency",
              "Release the emergency stop at the machine when it is safe, then --resume.", 4, false},
    CodeFacts{ErrorCode::machine_limit, "machine_limit",
              "Look whether the part lies where the part file says and within the machine's travel; then --resume.", 4,
              false},
    CodeFacts{ErrorCode::machine_door, "machine_door",
              "Close the door or leave the light curtain, then run the same command with --resume.", 4, false},
    CodeFacts{ErrorCode::machine_temperature, "machine_temperature",
              "Wait until machine and part are back in the range of temperature, then --resume.", 4, false},
    CodeFacts{ErrorCode::machine_deflection, "machine_deflection",
              "Look at stylus and clamping: the probe was bent too far. Qualify anew if it was hit, then --resume.", 4,
              false},
    CodeFacts{ErrorCode::machine_position, "machine_position",
              "The machine has lost its position: lead the probe clear of the part by hand, then --resume homes it.", 4,
              false},
    CodeFacts{ErrorCode::journal_io, "journal_io",
              "Check that the output folder exists, is writable, and is not in use by another run.", 6, false},
    CodeFacts{ErrorCode::journal_full, "journal_full",
              "Free space on the disk of the output folder, then run the same command with --resume: nothing measured "
              "is lost.",
              6, false},
    CodeFacts{ErrorCode::journal_slow, "journal_slow",
              "Give the output folder a faster or less busy disk, then run the same command with --resume: nothing "
              "measured is lost.",
              6, false},
    CodeFacts{ErrorCode::journal_corrupt, "journal_corrupt",
              "Keep the file; it was changed outside this program or the disk is failing.", 6, false},
    CodeFacts{ErrorCode::cancelled, "cancelled", "Run the same command with --resume to go on.", 4, false},
    CodeFacts{ErrorCode::internal, "internal", "This is a bug of cmmlive: please report it with the run file.", 70,
              false},
};

const CodeFacts& facts_of(ErrorCode code) noexcept {
    for (const auto& entry : facts) {
        if (entry.code == code) return entry;
    }
    return facts.back();
}

}  // namespace

std::string_view to_string(ErrorCode code) noexcept {
    return facts_of(code).name;
}
std::string_view advice(ErrorCode code) noexcept {
    return facts_of(code).advice;
}
bool retryable(ErrorCode code) noexcept {
    return facts_of(code).retryable;
}
int exit_code(ErrorCode code) noexcept {
    return facts_of(code).exit_code;
}

std::string_view to_string(Motion motion) noexcept {
    switch (motion) {
        case Motion::stopped:
            return "stopped";
        case Motion::may_be_moving:
            return "may_be_moving";
        case Motion::unknown:
            return "unknown";
        case Motion::not_concerned:
            return "not_concerned";
    }
    return "unknown";
}

Error& Error::with_context(std::string where) & {
    context.push_back(std::move(where));
    return *this;
}

Error&& Error::with_context(std::string where) && {
    context.push_back(std::move(where));
    return std::move(*this);
}

std::string Error::text() const {
    std::string line = message;
    for (const auto& where : context)
        line += " (" + where + ")";
    return line;
}

tl::unexpected<Error> fail(ErrorCode code, std::string message, Motion motion) {
    return tl::unexpected<Error>(Error{code, std::move(message), {}, motion});
}

}  // namespace cmm::core
