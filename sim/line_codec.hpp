// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The controller's side of docs/protocol-line.md: lines that come, lines and frames that go.
namespace cmm::sim {

struct LineCommand {
    std::uint16_t tag = 0;
    std::string verb;
    std::vector<std::string> arguments;
};
/// A line without its end; nothing when it is no command or its CRC does not fit.
std::optional<LineCommand> read_line_command(std::string_view line);
/// A whole number; nothing when the word is something else or too large.
std::optional<std::int64_t> line_number(const std::string& word);

/// "<mark><tag> <text>*<CRC>\n".
std::string line_reply(char mark, std::uint16_t tag, const std::string& text);
/// The word with blanks, '*', '%' and what is not printable as %XX.
std::string line_word(std::string_view text);

/// Builds a binary frame: numbers low byte first, then rows of numbers that change little.
class FrameWriter {
  public:
    void put(std::uint64_t value, std::size_t bytes);
    /// Seven bits a byte, low ones first.
    void put_varint(std::uint64_t value);
    /// Zero, CRC-32, COBS, zero.
    std::vector<std::uint8_t> finished() const;

  private:
    std::vector<std::uint8_t> bytes_;
};

/// A row of numbers as the distances from the straight line through the two before, zigzag, varint.
class LineRow {
  public:
    void put(FrameWriter& frame, std::int64_t value);

  private:
    std::vector<std::int64_t> past_;
};

}  // namespace cmm::sim
