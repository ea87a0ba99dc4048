// SPDX-License-Identifier: Apache-2.0
#include "drivers/linuxcnc/rsh_reply.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>

#include "core/text.hpp"

namespace cmm::drivers::linuxcnc {
namespace {

constexpr double mm_per_inch = 25.4;
constexpr double mm_per_cm = 10.0;

std::string capitals(std::string_view text) {
    std::string upper(text);
    std::transform(upper.begin(), upper.end(), upper.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return upper;
}

/// The first word, taken off the front of `rest`.
std::string_view take_word(std::string_view& rest) {
    rest = core::trim(rest);
    const auto end = std::min(rest.find_first_of(" \t"), rest.size());
    const auto word = rest.substr(0, end);
    rest = core::trim(rest.substr(end));
    return word;
}

/// The answer to SET or GET: its name and a verdict, nothing else.
Reply read_verdict(std::string_view rest, bool set) {
    Reply reply;
    reply.name = capitals(take_word(rest));
    const std::string verdict = capitals(rest);
    if (set && verdict == "ACK") reply.kind = Reply::Kind::done;
    if (verdict == "NAK") reply.kind = set ? Reply::Kind::refused : Reply::Kind::not_told;
    return reply;
}

struct Meaning {
    std::string_view words;  // of the text, in small letters
    core::ErrorCode code;
    std::string_view advice;
};

// The first that fits counts. The wording is LinuxCNC's, versions 2.8 to 2.9.
constexpr std::array meanings{
    Meaning{"probe tripped", core::ErrorCode::machine_fault,
            "the probe was touched where nothing was expected, or its signal bounces (docs/linuxcnc.md)"},
    Meaning{"already tripped", core::ErrorCode::machine_fault, "the probe was in contact before the touch began"},
    Meaning{"limit", core::ErrorCode::machine_limit, ""},
    Meaning{"home", core::ErrorCode::machine_refused, ""},
    Meaning{"following error", core::ErrorCode::machine_position, "an axis could not follow"},
    Meaning{"estop", core::ErrorCode::machine_emergency, ""},
    Meaning{"e-stop", core::ErrorCode::machine_emergency, ""},
};

}  // namespace

Reply read_reply(std::string_view line) {
    std::string_view rest = core::trim(line);
    const std::string first = capitals(take_word(rest));
    if (first == "SET" || first == "GET") return read_verdict(rest, first == "SET");
    Reply reply;
    if (first == "HELLO") {
        const std::string verdict = capitals(take_word(rest));
        if (verdict == "ACK") reply.kind = Reply::Kind::hello;
        if (verdict == "NAK") reply.kind = Reply::Kind::stranger;
    } else if (!first.empty()) {
        reply.kind = Reply::Kind::value;
    }
    reply.name = first;
    reply.text = std::string(rest);
    return reply;
}

std::optional<Eigen::Vector3d> read_position(std::string_view text) {
    const auto words = core::split(core::trim(text), ' ');
    if (words.size() < 3) return std::nullopt;
    Eigen::Vector3d position;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const auto number = core::parse_number(words[static_cast<std::size_t>(axis)]);
        if (!number) return std::nullopt;
        position[axis] = *number;
    }
    return position;
}

std::optional<bool> read_homed(std::string_view text, std::size_t joints) {
    const auto words = core::split(core::trim(text), ' ');
    if (joints == 0 || words.size() < joints) return std::nullopt;
    bool all = true;
    for (std::size_t joint = 0; joint < joints; ++joint) {
        const std::string word = capitals(words[joint]);
        if (word != "YES" && word != "HOMED" && word != "NO" && word != "NOT") return std::nullopt;
        all = all && (word == "YES" || word == "HOMED");
    }
    return all;
}

std::optional<bool> read_switch(std::string_view text) {
    const std::string word = capitals(core::trim(text));
    if (word == "ON" || word == "YES" || word == "1") return true;
    if (word == "OFF" || word == "NO" || word == "0") return false;
    return std::nullopt;
}

std::optional<double> read_unit_mm(std::string_view text) {
    const std::string word = capitals(core::trim(text));
    if (word == "MM") return 1.0;
    if (word == "INCH") return mm_per_inch;
    if (word == "CM") return mm_per_cm;
    return std::nullopt;
}

std::optional<Report> read_report(std::string_view text) {
    std::string_view rest = text;
    if (take_word(rest) != report_word || rest.empty()) return std::nullopt;
    Report report;
    for (const auto word : core::split(rest, ' ')) {
        const auto number = core::parse_number(word);
        if (!number) return std::nullopt;
        report.values.push_back(*number);
    }
    const double tag = report.values.front();
    if (!(tag >= 0.0 && tag <= std::numeric_limits<std::uint32_t>::max()) || tag != std::floor(tag))
        return std::nullopt;
    report.tag = static_cast<std::uint32_t>(tag);
    report.values.erase(report.values.begin());
    return report;
}

core::Error error_of_text(std::string_view text) {
    const std::string lower = core::in_small_letters(text);
    core::Error error{core::ErrorCode::machine_fault, "LinuxCNC says: " + std::string(text), {}, core::Motion::unknown};
    const auto* const found = std::find_if(meanings.begin(), meanings.end(), [&](const Meaning& meaning) {
        return lower.find(meaning.words) != std::string::npos;
    });
    if (found == meanings.end()) return error;
    error.code = found->code;
    if (!found->advice.empty()) error.message += " (" + std::string(found->advice) + ")";
    return error;
}

}  // namespace cmm::drivers::linuxcnc
