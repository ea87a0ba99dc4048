// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/exports.hpp"
#include "acquisition/listed_characteristic.hpp"
#include "acquisition/part_frame.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

constexpr int dfq_decimals = 6;
constexpr std::string_view valid = "0", invalid = "255";  // K0002

/// One line: a K field ends where its line ends, and control characters separate values.
std::string one_line(std::string_view text) {
    std::string line(text);
    std::replace_if(
        line.begin(), line.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
    return line;
}

/// "2026-11-23T09:11:36Z" as "23.11.2026/09:11:36"; nothing where it is no such time.
std::string time_text(std::string_view utc) {
    if (utc.size() != 20 || utc[4] != '-' || utc[10] != 'T') return {};
    const auto part = [&](std::size_t at, std::size_t count) { return std::string(utc.substr(at, count)); };
    return part(8, 2) + "." + part(5, 2) + "." + part(0, 4) + "/" + part(11, 8);
}

/// K fields, a line each; those of a characteristic carry its number.
class DfqText {
  public:
    void field(std::string_view key, std::string_view value, std::size_t characteristic = 0) {
        if (value.empty()) return;
        text_.append(key);
        if (characteristic > 0) text_ += "/" + std::to_string(characteristic);
        text_ += " " + one_line(value) + "\r\n";
    }
    void number(std::string_view key, const std::optional<double>& value, std::size_t characteristic) {
        if (value) field(key, core::fixed(*value, dfq_decimals), characteristic);
    }
    /// Readers take a file for the code page of their machine unless a mark says UTF-8.
    std::string finish() && {
        const bool plain = std::all_of(text_.begin(), text_.end(), [](unsigned char c) { return c < 0x80; });
        return plain ? std::move(text_) : "\xef\xbb\xbf" + text_;
    }

  private:
    std::string text_;
};

void describe(DfqText& text, const ListedCharacteristic& entry, std::size_t number) {
    const Characteristic& one = *entry.number;
    text.field("K2001", std::to_string(number), number);
    text.field("K2002", entry.name, number);
    text.field("K2004", "0", number);
    text.field("K2022", std::to_string(dfq_decimals), number);
    text.number("K2101", one.nominal, number);
    const bool from_zero = one.name.starts_with("profile_") && !one.lower;
    text.number("K2110", from_zero ? 0.0 : one.lower, number);
    text.number("K2111", one.upper, number);
    if (from_zero) text.field("K2120", "1", number);  // a natural limit: no zone is narrower than none
    text.field("K2142", to_string(one.unit), number);
    const std::string uncertainty = one.u95 ? "; U95 = " + core::fixed(*one.u95, dfq_decimals) : "";
    text.field("K2900", one.method + uncertainty, number);
}

}  // namespace

std::string dfq_text(const PartResult& part) {
    const auto entries = all_characteristics(part);
    DfqText text;
    text.field("K0100", std::to_string(entries.size()));
    text.field("K1001", part.part_name);
    text.field("K1002", part.part_name);
    text.field("K1082", part.machine);
    const Alignment* alignment = part.alignment();
    const bool of_blade = alignment != nullptr && alignment->spec.kind == AlignmentKind::blade;
    text.field("K1900", part.software_version + ", run " + part.run_id +
                            (part.part_frame ? ", part frame " + part_frame_words(*part.part_frame) : std::string()) +
                            (of_blade ? ", alignment of the blade " + alignment_words(*alignment) : std::string()));
    for (std::size_t k = 0; k < entries.size(); ++k)
        describe(text, entries[k], k + 1);
    for (std::size_t k = 0; k < entries.size(); ++k) {
        const Characteristic& one = *entries[k].number;
        text.number("K0001", one.value, k + 1);
        text.field("K0002", one.value ? valid : invalid, k + 1);
        text.field("K0004", time_text(part.started_utc), k + 1);
        text.field("K0009", one.note, k + 1);
        text.field("K0014", part.part_serial, k + 1);
    }
    return std::move(text).finish();
}

core::Status export_dfq(const PartResult& part, const std::string& file) {
    return core::write_file(file, dfq_text(part));
}

}  // namespace cmm::acquisition
