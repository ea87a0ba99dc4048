// SPDX-License-Identifier: Apache-2.0
#include "sim/registers.hpp"

#include <array>

namespace cmm::sim {
namespace {

constexpr std::array<std::uint16_t, 256> make_crc_table() {
    std::array<std::uint16_t, 256> table{};
    for (unsigned byte = 0; byte < 256; ++byte) {
        unsigned crc = byte;
        for (int bit = 0; bit < 8; ++bit)
            crc = (crc & 1U) != 0 ? (crc >> 1) ^ 0xA001U : crc >> 1;
        table[byte] = static_cast<std::uint16_t>(crc);
    }
    return table;
}
constexpr auto crc_table = make_crc_table();

constexpr std::uint16_t crc_byte(unsigned crc, unsigned byte) {
    return static_cast<std::uint16_t>((crc >> 8) ^ crc_table[(crc ^ byte) & 0xFFU]);
}

}  // namespace

std::uint16_t block_crc(std::span<const std::uint16_t> registers, std::size_t skip) noexcept {
    std::uint16_t crc = 0xFFFF;
    for (std::size_t i = 0; i < registers.size(); ++i) {
        if (i == skip) continue;
        crc = crc_byte(crc, registers[i] >> 8U);
        crc = crc_byte(crc, registers[i] & 0xFFU);
    }
    return crc;
}

void RegisterWriter::put_words(std::size_t at, std::uint64_t value, std::size_t words) {
    for (std::size_t i = 0; i < words; ++i) {
        const std::size_t place = big_words_ ? at + words - 1 - i : at + i;
        registers_[place] = static_cast<std::uint16_t>(value >> (16 * i));
    }
}

void RegisterWriter::put_bits(std::size_t at, std::size_t words, unsigned bit, unsigned bits, std::uint32_t value) {
    const std::uint64_t mask = ((std::uint64_t{1} << bits) - 1) << bit;
    const std::uint64_t present = words == 1 ? registers_[at] : get32(registers_, at, big_words_);
    put_words(at, (present & ~mask) | ((std::uint64_t{value} << bit) & mask), words);
}

void RegisterWriter::put_text(std::size_t at, std::size_t length, std::string_view text) {
    for (std::size_t i = 0; i < length; ++i) {
        const auto byte = [&](std::size_t k) {
            return k < text.size() ? static_cast<unsigned>(static_cast<unsigned char>(text[k])) : 0U;
        };
        registers_[at + i] = static_cast<std::uint16_t>(byte(2 * i) << 8U | byte(2 * i + 1));
    }
}

std::uint32_t get32(std::span<const std::uint16_t> registers, std::size_t at, bool big_words) noexcept {
    const std::uint32_t first = registers[at];
    const std::uint32_t second = registers[at + 1];
    return big_words ? first << 16U | second : second << 16U | first;
}

}  // namespace cmm::sim
