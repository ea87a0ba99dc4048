// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace cmm::sim {

/// CRC-16/MODBUS over registers as big-endian bytes in address order, leaving out the register at `skip`.
std::uint16_t block_crc(std::span<const std::uint16_t> registers, std::size_t skip) noexcept;

/// Puts wide values into a block of registers and takes them out. Does not own the registers; the caller has checked
/// that the offsets lie inside. `big_words`: high word first.
class RegisterWriter {
  public:
    RegisterWriter(std::span<std::uint16_t> registers, bool big_words) : registers_(registers), big_words_(big_words) {}
    void put16(std::size_t at, std::uint16_t value) { registers_[at] = value; }
    void put32(std::size_t at, std::uint32_t value) { put_words(at, value, 2); }
    void put48(std::size_t at, std::uint64_t value) { put_words(at, value, 3); }
    /// Only `bits` bits from `bit` on, of `words` registers; what else is in them stays.
    void put_bits(std::size_t at, std::size_t words, unsigned bit, unsigned bits, std::uint32_t value);
    void put_text(std::size_t at, std::size_t length, std::string_view text);

  private:
    void put_words(std::size_t at, std::uint64_t value, std::size_t words);
    std::span<std::uint16_t> registers_;
    bool big_words_;
};

std::uint32_t get32(std::span<const std::uint16_t> registers, std::size_t at, bool big_words) noexcept;

}  // namespace cmm::sim
