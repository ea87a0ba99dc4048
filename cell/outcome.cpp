// SPDX-License-Identifier: Apache-2.0
#include "cell/outcome.hpp"

#include <algorithm>
#include <array>

namespace cmm::cell {
namespace {

using core::ErrorCode;

struct Number {
    ErrorCode code;
    std::uint16_t number;
    std::string_view text;
};

// Numbers are for ever: new codes get new ones.
constexpr std::array numbers{
    Number{ErrorCode::usage, 300, "the run cannot be made this way"},
    Number{ErrorCode::config_syntax, 301, "a configuration file does not parse"},
    Number{ErrorCode::config_invalid, 302, "a value in a configuration file does not hold"},
    Number{ErrorCode::input_missing, 303, "a file is missing"},
    Number{ErrorCode::input_invalid, 304, "a file is broken"},
    Number{ErrorCode::plan_invalid, 305, "the plan of the part was refused"},
    Number{ErrorCode::fit_not_evaluable, 306, "the points do not determine the result"},
    Number{ErrorCode::machine_busy, 400, "the machine is busy"},
    Number{ErrorCode::machine_refused, 401, "the machine refused a command"},
    Number{ErrorCode::machine_fault, 402, "the machine stopped with a fault"},
    Number{ErrorCode::machine_no_contact, 403, "the probe found no part"},
    Number{ErrorCode::machine_overflow, 404, "the machine's sample buffer ran over"},
    Number{ErrorCode::machine_watchdog, 405, "the machine did not hear from the host"},
    Number{ErrorCode::machine_emergency, 406, "the machine's emergency stop is pressed"},
    Number{ErrorCode::machine_limit, 407, "a place lies outside the travel"},
    Number{ErrorCode::machine_door, 408, "a door of the machine is open"},
    Number{ErrorCode::machine_temperature, 409, "the machine is too warm or too cold"},
    Number{ErrorCode::machine_deflection, 410, "the probe was bent too far"},
    Number{ErrorCode::machine_position, 411, "the machine does not know its position"},
    Number{ErrorCode::cancelled, 203, "stopped at the host"},
    Number{ErrorCode::transport_connect, 500, "the machine does not answer"},
    Number{ErrorCode::transport_timeout, 501, "the machine answered too late"},
    Number{ErrorCode::transport_closed, 502, "the link to the machine broke"},
    Number{ErrorCode::protocol_mismatch, 503, "the machine is not the one that is expected"},
    Number{ErrorCode::protocol_invalid, 504, "the machine's answers make no sense"},
    Number{ErrorCode::journal_io, 600, "the run file cannot be written"},
    Number{ErrorCode::journal_full, 601, "the disk is full"},
    Number{ErrorCode::journal_slow, 602, "the disk is too slow"},
    Number{ErrorCode::journal_corrupt, 603, "the run file is damaged"},
    Number{ErrorCode::internal, 700, "an error of cmmlive itself"},
};

constexpr std::array<std::string_view, 6> result_names{"none",      "accepted", "rejected",
                                                       "undecided", "error",    "measured"};

}  // namespace

Reason reason_of(ErrorCode code) noexcept {
    const auto* const found =
        std::find_if(numbers.begin(), numbers.end(), [code](const Number& known) { return known.code == code; });
    return found == numbers.end() ? Reason::internal : static_cast<Reason>(found->number);
}

Reason reason_of(std::string_view code_name) noexcept {
    const auto* const found = std::find_if(numbers.begin(), numbers.end(), [code_name](const Number& known) {
        return core::to_string(known.code) == code_name;
    });
    return found == numbers.end() ? Reason::internal : static_cast<Reason>(found->number);
}

std::string_view to_string(CellResult result) noexcept {
    return result_names[static_cast<std::size_t>(result)];
}

std::string_view text_of(Reason reason) noexcept {
    switch (reason) {
        case Reason::none:
            return "";
        case Reason::conforming:
            return "conforms";
        case Reason::out_of_tolerance:
            return "out of tolerance";
        case Reason::out_while_measuring:
            return "out of tolerance, certain while it was measured";
        case Reason::undecided:
            return "the uncertainty is too large, or something was not evaluable";
        case Reason::no_program:
            return "there is no part file of this program number";
        case Reason::program_invalid:
            return "the part file of this program number cannot be used";
        case Reason::no_part:
            return "start without part present";
        case Reason::serial_invalid:
            return "the serial number has characters that it must not have";
        case Reason::aborted:
            return "aborted by the PLC";
        case Reason::part_removed:
            return "the part was taken away";
        case Reason::plc_silent:
            return "the PLC was silent for too long";
        case Reason::service_stopped:
            return "the service was stopped";
        case Reason::service_restarted:
            return "the service began anew while the part was measured";
        default:
            break;
    }
    const auto* const found = std::find_if(numbers.begin(), numbers.end(), [reason](const Number& known) {
        return known.number == static_cast<std::uint16_t>(reason);
    });
    return found == numbers.end() ? "an error of cmmlive itself" : found->text;
}

}  // namespace cmm::cell
