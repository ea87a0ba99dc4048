// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/line_codec.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace cmm::drivers::line {
namespace {

constexpr std::size_t crc_digits = 4;
constexpr std::size_t crc32_bytes = 4;
constexpr std::size_t shortest_payload = 3;  // kind and tag
constexpr std::uint8_t samples_kind = 'S';

constexpr auto crc32_table = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t k = 0; k < table.size(); ++k) {
        std::uint32_t value = k;
        for (int bit = 0; bit < 8; ++bit)
            value = (value & 1U) != 0 ? (value >> 1U) ^ 0xEDB88320U : value >> 1U;
        table[k] = value;
    }
    return table;
}();

std::string hex4(std::uint16_t value) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    std::string text;
    for (unsigned shift = 16; shift > 0;) {
        shift -= 4;
        text += digits[(value >> shift) & 15U];
    }
    return text;
}

/// The line without '*' and CRC, when the CRC fits.
std::optional<std::string_view> checked(std::string_view line) {
    if (line.size() < crc_digits + 1) return std::nullopt;
    const std::string_view covered = line.substr(0, line.size() - crc_digits - 1);
    if (line[covered.size()] != '*' || line.substr(covered.size() + 1) != hex4(crc16(covered))) return std::nullopt;
    return covered;
}

std::optional<Message> message_of(std::string_view line) {
    const auto covered = checked(line);
    if (!covered || covered->empty() || (covered->front() != '=' && covered->front() != '!')) return std::nullopt;
    Message message;
    message.kind = covered->front() == '=' ? Message::Kind::answer : Message::Kind::refusal;
    const char* const end = covered->data() + covered->size();
    const auto [rest, error] = std::from_chars(covered->data() + 1, end, message.tag);
    if (error != std::errc{} || (rest != end && *rest != ' ')) return std::nullopt;
    if (rest != end) message.text.assign(rest + 1, end);
    return message;
}

}  // namespace

std::uint16_t crc16(std::string_view text) noexcept {
    std::uint32_t crc = 0xFFFF;
    for (const char c : text) {
        crc ^= static_cast<std::uint32_t>(static_cast<unsigned char>(c)) << 8U;
        for (int bit = 0; bit < 8; ++bit)
            crc = ((crc & 0x8000U) != 0 ? (crc << 1U) ^ 0x1021U : crc << 1U) & 0xFFFFU;
    }
    return static_cast<std::uint16_t>(crc);
}

std::uint32_t crc32(std::span<const std::uint8_t> bytes) noexcept {
    std::uint32_t crc = 0xFFFFFFFFU;
    for (const std::uint8_t byte : bytes)
        crc = (crc >> 8U) ^ crc32_table[(crc ^ byte) & 0xFFU];
    return ~crc;
}

std::string command_line(std::uint16_t tag, std::string_view body) {
    const std::string covered = "#" + std::to_string(tag) + " " + std::string(body);
    return covered + "*" + hex4(crc16(covered)) + "\n";
}

void Parser::feed(std::span<const std::uint8_t> bytes, std::vector<Message>& messages) {
    for (const std::uint8_t byte : bytes) {
        if (byte == 0) {
            // Two zeros in a row: the first ended a frame whose beginning was lost, or nothing.
            if (in_frame_ && !collected_.empty()) {
                end_frame(messages);
            } else {
                if (!in_frame_ && !collected_.empty()) ++spoilt_;
                in_frame_ = true;
            }
            collected_.clear();
        } else if (byte == '\n' && !in_frame_) {
            end_line(messages);
            collected_.clear();
        } else if (collected_.size() < longest) {
            collected_.push_back(byte);
        } else {
            ++spoilt_;
            reset();
        }
    }
}

void Parser::reset() noexcept {
    collected_.clear();
    in_frame_ = false;
}

void Parser::end_line(std::vector<Message>& messages) {
    std::string line(collected_.begin(), collected_.end());
    if (line.ends_with('\r')) line.pop_back();
    if (line.empty()) return;
    if (auto message = message_of(line)) {
        messages.push_back(std::move(*message));
    } else {
        ++spoilt_;
    }
}

void Parser::end_frame(std::vector<Message>& messages) {
    in_frame_ = false;
    auto payload = cobs_decoded(collected_);
    if (!payload || payload->size() < shortest_payload + crc32_bytes || payload->front() != samples_kind) {
        ++spoilt_;
        return;
    }
    const std::size_t covered = payload->size() - crc32_bytes;
    std::uint32_t crc = 0;
    for (std::size_t k = 0; k < crc32_bytes; ++k)
        crc |= static_cast<std::uint32_t>((*payload)[covered + k]) << (8 * k);
    if (crc != crc32(std::span(*payload).first(covered))) {
        ++spoilt_;
        return;
    }
    payload->resize(covered);
    Message message;
    message.kind = Message::Kind::samples;
    message.tag = static_cast<std::uint16_t>((*payload)[1] | (*payload)[2] << 8U);
    message.payload = std::move(*payload);
    messages.push_back(std::move(message));
}

std::optional<std::vector<std::uint8_t>> cobs_decoded(std::span<const std::uint8_t> bytes) {
    std::vector<std::uint8_t> out;
    out.reserve(bytes.size());
    for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t code = bytes[at];
        if (code == 0 || at + code > bytes.size()) return std::nullopt;
        const auto block = bytes.subspan(at + 1, code - 1);
        if (std::find(block.begin(), block.end(), std::uint8_t{0}) != block.end()) return std::nullopt;
        out.insert(out.end(), block.begin(), block.end());
        at += code;
        if (code < 255 && at < bytes.size()) out.push_back(0);
    }
    return out;
}

}  // namespace cmm::drivers::line
