// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

/// What linuxcncrsh answers (man linuxcncrsh), line by line. No I/O here.
namespace cmm::drivers::linuxcnc {

struct Reply {
    enum class Kind : std::uint8_t {
        hello,        ///< HELLO ACK; the text is the server's name and version
        stranger,     ///< HELLO NAK: wrong password
        done,         ///< SET name ACK
        refused,      ///< SET name NAK
        not_told,     ///< GET name NAK
        value,        ///< name and text, the answer to GET
        meaningless,  ///< echoes of our own lines among them
    };
    Kind kind = Kind::meaningless;
    std::string name;  ///< what was set or asked for, in capitals
    std::string text;  ///< of a value
};

/// A line without its end.
Reply read_reply(std::string_view line);

/// The linear axes X, Y, Z of ABS_CMD_POS and its like, in the units of the controller; nothing: not three numbers.
std::optional<Eigen::Vector3d> read_position(std::string_view text);
/// Whether the first `joints` of JOINT_HOMED are; linuxcncrsh tells of six and more, however many there are.
std::optional<bool> read_homed(std::string_view text, std::size_t joints);
/// ON, YES and 1, or OFF, NO and 0.
std::optional<bool> read_switch(std::string_view text);
/// Millimetres in a unit of USER_LINEAR_UNITS.
std::optional<double> read_unit_mm(std::string_view text);

/// What our own (DEBUG,CMMLIVE ...) printed.
struct Report {
    std::uint32_t tag = 0;       ///< of the question
    std::vector<double> values;  ///< in millimetres where they are lengths: G21 is on
};
inline constexpr std::string_view report_word = "CMMLIVE";
/// Nothing: the operator display shows something else.
std::optional<Report> read_report(std::string_view text);

/// What an error text of LinuxCNC means; the text itself goes into the message.
core::Error error_of_text(std::string_view text);

}  // namespace cmm::drivers::linuxcnc
