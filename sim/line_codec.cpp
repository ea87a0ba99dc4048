// SPDX-License-Identifier: Apache-2.0
#include "sim/line_codec.hpp"

#include <cctype>
#include <charconv>
#include <cstdio>
#include <utility>

namespace cmm::sim {
namespace {

/// CRC-16/IBM-3740 by the byte-wise shifts of its polynomial x^16 + x^12 + x^5 + 1.
unsigned text_crc(std::string_view text) {
    unsigned crc = 0xFFFF;
    for (const char c : text) {
        unsigned x = (crc >> 8U) ^ static_cast<unsigned char>(c);
        x ^= x >> 4U;
        crc = ((crc << 8U) ^ (x << 12U) ^ (x << 5U) ^ x) & 0xFFFFU;
    }
    return crc;
}

std::string crc_text(std::string_view covered) {
    char text[8];
    std::snprintf(text, sizeof text, "%04X", text_crc(covered));
    return text;
}

std::uint32_t frame_crc(std::span<const std::uint8_t> bytes) {
    std::uint32_t crc = 0xFFFFFFFFU;
    for (const std::uint8_t byte : bytes) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit)
            crc = (crc >> 1U) ^ (0xEDB88320U & (0U - (crc & 1U)));
    }
    return ~crc;
}

/// Consistent overhead byte stuffing (Cheshire, Baker 1999).
std::vector<std::uint8_t> stuffed(std::span<const std::uint8_t> bytes) {
    std::vector<std::uint8_t> out{0};  // room for the first code
    std::size_t code_at = 0;
    bool open = true;  // a block is begun
    for (const std::uint8_t byte : bytes) {
        if (!open) {
            code_at = out.size();
            out.push_back(0);
            open = true;
        }
        if (byte != 0) out.push_back(byte);
        const std::size_t code = out.size() - code_at;
        if (byte != 0 && code < 255) continue;
        out[code_at] = static_cast<std::uint8_t>(code);
        open = false;
        if (byte == 0) {  // the end of a block stands for it, so another one must follow
            code_at = out.size();
            out.push_back(0);
            open = true;
        }
    }
    if (open) out[code_at] = static_cast<std::uint8_t>(out.size() - code_at);
    return out;
}

}  // namespace

std::optional<std::int64_t> line_number(const std::string& word) {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    return value;
}

std::optional<LineCommand> read_line_command(std::string_view line) {
    const std::size_t start = line.rfind('#');  // noise before it does not matter
    const std::size_t star = line.rfind('*');
    if (start == std::string_view::npos || star == std::string_view::npos || star < start) return std::nullopt;
    const std::string_view covered = line.substr(start, star - start);
    if (line.substr(star + 1) != crc_text(covered)) return std::nullopt;
    std::vector<std::string> words;
    std::string word;
    for (const char c : covered.substr(1)) {
        if (c != ' ') {
            word += c;
        } else if (!word.empty()) {
            words.push_back(std::exchange(word, {}));
        }
    }
    if (!word.empty()) words.push_back(word);
    if (words.size() < 2) return std::nullopt;
    const auto tag = line_number(words[0]);
    if (!tag || *tag < 1 || *tag > 65535) return std::nullopt;
    return LineCommand{static_cast<std::uint16_t>(*tag), words[1], {words.begin() + 2, words.end()}};
}

std::string line_reply(char mark, std::uint16_t tag, const std::string& text) {
    const std::string covered = mark + std::to_string(tag) + (text.empty() ? "" : " " + text);
    return covered + "*" + crc_text(covered) + "\n";
}

std::string line_word(std::string_view text) {
    std::string word;
    for (const char c : text) {
        const bool plain = std::isgraph(static_cast<unsigned char>(c)) != 0 && c != '*' && c != '%';
        char escaped[4];
        std::snprintf(escaped, sizeof escaped, "%%%02X", static_cast<unsigned>(static_cast<unsigned char>(c)));
        word += plain ? std::string(1, c) : escaped;
    }
    return word.empty() ? "-" : word;
}

void FrameWriter::put(std::uint64_t value, std::size_t bytes) {
    for (std::size_t k = 0; k < bytes; ++k)
        bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

void FrameWriter::put_varint(std::uint64_t value) {
    for (; value >= 0x80U; value >>= 7U)
        bytes_.push_back(static_cast<std::uint8_t>(value | 0x80U));
    bytes_.push_back(static_cast<std::uint8_t>(value));
}

std::vector<std::uint8_t> FrameWriter::finished() const {
    FrameWriter whole = *this;
    whole.put(frame_crc(bytes_), 4);
    std::vector<std::uint8_t> out{0};
    const auto inner = stuffed(whole.bytes_);
    out.insert(out.end(), inner.begin(), inner.end());
    out.push_back(0);
    return out;
}

void LineRow::put(FrameWriter& frame, std::int64_t value) {
    const std::size_t n = past_.size();
    const std::int64_t expected = n == 0 ? 0 : n == 1 ? past_[0] : 2 * past_[n - 1] - past_[n - 2];
    const std::int64_t off = value - expected;
    frame.put_varint(off < 0 ? 2 * static_cast<std::uint64_t>(-(off + 1)) + 1 : 2 * static_cast<std::uint64_t>(off));
    past_.push_back(value);
}

}  // namespace cmm::sim
