// SPDX-License-Identifier: Apache-2.0
#include "cell/registers.hpp"

#include <algorithm>

namespace cmm::cell {
namespace {

/// The part of a block that is asked for; empty: it does not lie in it.
template <class Block, class Words>
auto part_of(Words& words, std::size_t address, std::size_t count) {
    const std::span all(words);
    if (address < Block::first || address + count > Block::first + all.size()) return all.first(0);
    return all.subspan(address - Block::first, count);
}

}  // namespace

std::string PlcBlock::serial_text() const {
    std::string text;
    for (std::size_t i = serial; i < count; ++i) {
        text.push_back(static_cast<char>(words[i] >> 8U));
        text.push_back(static_cast<char>(words[i] & 0xFFU));
    }
    text.resize(std::min(text.size(), text.find('\0')));
    while (text.ends_with(' '))
        text.pop_back();
    return text;
}

CellBlock::CellBlock() {
    words[identity] = 0x4345;
    words[identity + 1] = 0x4C4C;
    words[map_version] = 1;
}

void CellBlock::put_serial(const std::string& text) {
    const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
    for (std::size_t i = 0; i < serial_registers; ++i)
        words[serial + i] = static_cast<std::uint16_t>(byte(2 * i) << 8U | byte(2 * i + 1));
}

void CellBlock::put_run(std::uint32_t number) {
    words[run] = static_cast<std::uint16_t>(number >> 16U);
    words[run + 1] = static_cast<std::uint16_t>(number & 0xFFFFU);
}

ModbusException read_registers(const PlcBlock& plc, const CellBlock& cell, std::size_t address,
                               std::span<std::uint16_t> to) noexcept {
    auto found = part_of<PlcBlock>(plc.words, address, to.size());
    if (found.empty()) found = part_of<CellBlock>(cell.words, address, to.size());
    if (found.empty()) return ModbusException::illegal_address;
    std::copy(found.begin(), found.end(), to.begin());
    return ModbusException::none;
}

ModbusException write_registers(PlcBlock& plc, std::size_t address, std::span<const std::uint16_t> from) noexcept {
    PlcBlock after = plc;
    const auto place = part_of<PlcBlock>(after.words, address, from.size());
    if (place.empty()) return ModbusException::illegal_address;
    std::copy(from.begin(), from.end(), place.begin());
    if ((after.words[PlcBlock::command] & ~command_bit::all) != 0 || after.words[PlcBlock::reserved] != 0)
        return ModbusException::illegal_value;
    plc = after;
    return ModbusException::none;
}

bool is_serial(const std::string& text) noexcept {
    return std::all_of(text.begin(), text.end(),
                       [](char letter) { return letter >= ' ' && letter <= '~' && letter != '"' && letter != '\\'; });
}

}  // namespace cmm::cell
