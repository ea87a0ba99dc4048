// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Messages of the line protocol (docs/protocol-line.md), whole and unharmed or not at all. Pure.
namespace cmm::drivers::line {

/// CRC-16 of text lines (poly 0x1021, start 0xFFFF; "123456789" gives 29B1).
std::uint16_t crc16(std::string_view text) noexcept;
/// CRC-32 of binary frames, that of Ethernet and zip ("123456789" gives CBF43926).
std::uint32_t crc32(std::span<const std::uint8_t> bytes) noexcept;

/// "#<tag> <body>*<CRC>\n".
std::string command_line(std::uint16_t tag, std::string_view body);

struct Message {
    enum class Kind : std::uint8_t {
        answer,   ///< "=": text holds the values
        refusal,  ///< "!": text holds the code
        samples,  ///< binary: payload without its CRC
    };
    Kind kind = Kind::answer;
    std::uint16_t tag = 0;
    std::string text;
    std::vector<std::uint8_t> payload;
};

/// Cuts what a controller sends into messages. Any bytes are allowed; what is no message is counted and dropped.
class Parser {
  public:
    /// Longest message, text or encoded; more is noise.
    static constexpr std::size_t longest = 4096;

    /// Appends the messages that these bytes complete.
    void feed(std::span<const std::uint8_t> bytes, std::vector<Message>& messages);
    /// Forgets a message begun: what follows begins a new one.
    void reset() noexcept;
    /// Messages with a wrong CRC, and noise between messages.
    std::uint64_t spoilt() const noexcept { return spoilt_; }

  private:
    void end_line(std::vector<Message>& messages);
    void end_frame(std::vector<Message>& messages);

    std::vector<std::uint8_t> collected_;
    bool in_frame_ = false;
    std::uint64_t spoilt_ = 0;
};

/// Undoes COBS (Cheshire, Baker 1999); nothing when the bytes are not of it.
std::optional<std::vector<std::uint8_t>> cobs_decoded(std::span<const std::uint8_t> bytes);

}  // namespace cmm::drivers::line
