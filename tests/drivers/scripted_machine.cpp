// SPDX-License-Identifier: Apache-2.0
#include "scripted_machine.hpp"

#include <algorithm>

namespace cmm::drivers::test {
namespace {

// Addresses of the document.
constexpr std::size_t status = 64, command_block = 128, stop_register = 200, path_block = 256, exchange_block = 384,
                      fifo = 400;
constexpr int points_per_exchange = 5;

/// The CRC bit by bit, as the standard's text has it.
std::uint16_t crc_of(const std::vector<std::uint16_t>& words) {
    unsigned crc = 0xFFFF;
    for (const unsigned w : words) {
        for (const unsigned byte : {w / 256, w % 256}) {
            crc ^= byte;
            for (int bit = 0; bit < 8; ++bit)
                crc = crc % 2 == 1 ? (crc / 2) ^ 0xA001 : crc / 2;
        }
    }
    return static_cast<std::uint16_t>(crc);
}

}  // namespace

std::uint16_t word(const Bytes& bytes, std::size_t at) {
    return static_cast<std::uint16_t>(bytes[at] * 256 + bytes[at + 1]);
}

void add_word(Bytes& bytes, std::size_t value) {
    bytes.push_back(static_cast<std::uint8_t>(value / 256 % 256));
    bytes.push_back(static_cast<std::uint8_t>(value % 256));
}

ScriptedMachine::ScriptedMachine() {
    seed_identity();
    refresh_status();
}

void ScriptedMachine::seed_identity() {
    registers_[0] = 0x434D;
    registers_[1] = 0x4D31;
    registers_[2] = 1;
    registers_[3] = 2 * 256 + 7;
    const std::string model = "scripted";
    for (std::size_t k = 0; k < model.size(); k += 2) {
        registers_[4 + k / 2] = static_cast<std::uint16_t>(model[k] * 256 + model[k + 1]);
    }
    registers_[12] = 'A' * 256 + '1';
    registers_[20] = 100;
    registers_[21] = 1000;
    registers_[22] = 4096;
    registers_[23] = 40;  // path points ahead of the probe
    registers_[24] = 10;
    registers_[25] = 500;
    registers_[26] = 15;
    registers_[27] = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        put32(28 + 2 * axis, static_cast<std::uint32_t>(-5'000'000));
        put32(34 + 2 * axis, 5'000'000);
    }
    put32(40, 400'000);
    put32(42, 1'500'000);
    registers_[44] = 77;
    set_crc(0, 46, 45);
}

void ScriptedMachine::set_register(std::size_t address, std::uint16_t value, bool mend_crc) {
    registers_[address] = value;
    if (mend_crc && address < 46) set_crc(0, 46, 45);
}

void ScriptedMachine::end_motion(std::uint16_t result, std::uint16_t state) {
    finish(3, result);
    registers_[status] = state;
    refresh_status();
}

void ScriptedMachine::restart() {
    registers_[44] = static_cast<std::uint16_t>(registers_[44] + 1);
    set_crc(0, 46, 45);
    samples_.clear();
    acknowledged_ = 0;
    owner_ = 0;
    running_opcode_ = 0;
    for (std::size_t k = 0; k < 37; ++k)
        registers_[status + k] = 0;
    refresh_status();
}

int ScriptedMachine::executed(int opcode) const {
    const auto at = executed_.find(opcode);
    return at == executed_.end() ? 0 : at->second;
}

Bytes ScriptedMachine::execute(const Bytes& pdu) {
    const std::uint8_t function = pdu[0];
    const std::size_t address = word(pdu, 1);
    if (function == 3) return read_registers(function, address, word(pdu, 3));
    std::vector<std::uint16_t> values;
    if (function == 6) {
        values.push_back(word(pdu, 3));
    } else {
        const std::size_t head = function == 23 ? 10 : 6;  // bytes before the values
        for (std::size_t at = head; at + 1 < pdu.size(); at += 2)
            values.push_back(word(pdu, at));
    }
    int exception = 0;
    const std::size_t write_address = function == 23 ? word(pdu, 5) : address;
    if (!write_registers(write_address, values, exception)) {
        return {static_cast<std::uint8_t>(function | 0x80), static_cast<std::uint8_t>(exception)};
    }
    if (function == 23) return read_registers(function, address, word(pdu, 3));
    return Bytes(pdu.begin(), pdu.begin() + 5);
}

Bytes ScriptedMachine::read_registers(std::size_t function, std::size_t address, std::size_t count) {
    Bytes body{static_cast<std::uint8_t>(function), static_cast<std::uint8_t>(2 * count)};
    for (std::size_t k = 0; k < count; ++k)
        add_word(body, registers_[address + k]);
    return body;
}

bool ScriptedMachine::write_registers(std::size_t address, const std::vector<std::uint16_t>& values, int& exception) {
    exception = 2;
    if (address == stop_register) {
        stop(values[0]);
        return true;
    }
    if (address == path_block) return take_window(values, exception);
    if (address != command_block && address != exchange_block) return false;
    std::copy(values.begin(), values.end(), registers_.begin() + static_cast<std::ptrdiff_t>(address));
    if (address == command_block) {
        const std::vector<std::uint16_t> covered(values.begin(), values.end() - 1);
        exception = 3;
        if (values.size() != 21 || crc_of(covered) != values.back()) return false;
        command();
    } else {
        step();
        exchange();
    }
    return true;
}

void ScriptedMachine::command() {
    if (registers_[command_block] == registers_[status + 4]) return;  // once per sequence
    const std::uint16_t opcode = registers_[command_block + 1];
    const std::uint32_t owner = get32(command_block + 2);
    registers_[status + 4] = registers_[command_block];
    const auto arg = [this](std::size_t k) { return get32(command_block + 4 + 2 * k); };
    const auto done = [this](std::uint16_t result) { finish(result == 0 ? 2 : 3, result); };
    if (opcode != 1 && opcode != 8 && owner != owner_) return done(7);
    if (running_opcode_ != 0) return done(5);
    ++executed_[opcode];
    switch (opcode) {
        case 1:
            if (owner_ != 0 && owner_ != owner) return done(7);
            owner_ = owner;
            return done(0);
        case 2:
            owner_ = 0;
            return done(0);
        case 3:
            return begin_motion(1);
        case 4:
            return begin_motion(9);
        case 5:
            return begin_motion(2);
        case 6:
            return begin_motion(3);
        case 7:
            return begin_motion(4);
        case 9:
            if (registers_[status] == 8 && arg(0) != 1) return done(4);
            registers_[status] = 0;
            registers_[status + 3] = 0;
            return done(0);
        case 10:
            path_.clear();
            passed_ = 0;
            path_id_ = static_cast<std::uint16_t>(arg(0));
            return done(0);
        default:
            return done(1);
    }
}

void ScriptedMachine::begin_motion(std::uint16_t state) {
    if (registers_[status] >= 6 && registers_[status] <= 8) return finish(3, 4);
    running_opcode_ = registers_[command_block + 1];
    registers_[status] = state;
    registers_[status + 5] = 1;
    registers_[status + 6] = 0;
    steps_left_ = exchanges_per_motion_;
    refresh_status();
}

void ScriptedMachine::finish(std::uint16_t command_state, std::uint16_t result) {
    if (running_opcode_ != 0) registers_[status] = 0;
    running_opcode_ = 0;
    registers_[status + 5] = command_state;
    registers_[status + 6] = result;
    refresh_status();
}

void ScriptedMachine::stop(std::uint16_t kind) {
    stop_value_ = kind;
    stop_arrived_ = std::chrono::steady_clock::now();
    if (running_opcode_ != 0) finish(3, kind == 2 ? 12 : 13);
    registers_[status] = kind == 2 ? 8 : 6;
    registers_[status + 3] = kind == 2 ? 12 : 13;
    refresh_status();
}

bool ScriptedMachine::take_window(const std::vector<std::uint16_t>& values, int& exception) {
    exception = 3;
    std::vector<std::uint16_t> covered = values;
    covered.erase(covered.begin() + 4);
    const std::size_t first = values[1] * std::size_t{65536} + values[2];
    const std::size_t count = values[3];
    if (values.size() != 6 + 11 * count || crc_of(covered) != values[4] || values[0] != path_id_) return false;
    if (first > path_.size()) return false;
    exception = 6;
    if (first + count > passed_ + registers_[23]) return false;
    for (std::size_t k = 0; k < count; ++k) {
        const auto* begin = values.data() + 6 + 11 * k;
        if (first + k >= path_.size()) path_.emplace_back(begin, begin + 11);
    }
    refresh_status();
    return true;
}

void ScriptedMachine::step() {
    registers_[status + 1] = static_cast<std::uint16_t>(registers_[status + 1] + 1);
    if (running_opcode_ == 7) return advance_scan();
    if (running_opcode_ == 0 || --steps_left_ > 0) return;
    if (running_opcode_ == 3) registers_[status + 2] |= 1U;
    if (running_opcode_ == 4) registers_[status + 2] |= 2U;
    if (running_opcode_ == 6) {
        StoredSample touched{{}, path_id_, true};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            touched.counts[axis] = static_cast<std::int32_t>(get32(command_block + 4 + 2 * axis));
            put32(status + 7 + 2 * axis, get32(command_block + 4 + 2 * axis));
        }
        samples_.push_back(touched);
    }
    finish(2, 0);
}

void ScriptedMachine::advance_scan() {
    for (int k = 0; k < points_per_exchange && passed_ < path_.size(); ++k) {
        const auto& point = path_[passed_++];
        const auto coordinate = [&](std::size_t axis) {
            return static_cast<std::int32_t>(point[2 * axis] * 65536U + point[2 * axis + 1]);
        };
        if (point[10] % 2 == 1) samples_.push_back({{coordinate(0), coordinate(1), coordinate(2)}, path_id_, false});
        if (point[10] / 2 == 1) return finish(2, 0);
    }
    registers_[status] = passed_ < path_.size() ? 4 : 5;
    refresh_status();
}

void ScriptedMachine::exchange() {
    acknowledged_ = std::max(acknowledged_, get32(exchange_block + 1));
    const std::uint32_t from = get32(exchange_block + 3);
    const std::uint32_t first = std::max(from == 0 ? acknowledged_ + 1 : from, acknowledged_ + 1);
    const auto newest = static_cast<std::uint32_t>(samples_.size());
    std::fill_n(registers_.begin() + fifo, 125, std::uint16_t{0});
    std::size_t count = 0;
    const std::uint16_t path = first <= newest ? samples_[first - 1].path : path_id_;
    for (std::uint32_t n = first; n <= newest && count < 14 && samples_[n - 1].path == path; ++n, ++count) {
        const std::size_t at = fifo + 13 + 8 * count;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            put32(at + 2 * axis, static_cast<std::uint32_t>(samples_[n - 1].counts[axis]));
        }
        registers_[at + 6] = count == 0 ? 0 : 100;  // 1 ms
        registers_[at + 7] = samples_[n - 1].touch ? 4 : 0;
    }
    registers_[fifo] = registers_[status];
    registers_[fifo + 1] = registers_[status + 1];
    registers_[fifo + 2] = path;
    put32(fifo + 3, first);
    put32(fifo + 5, newest);
    registers_[fifo + 7] = static_cast<std::uint16_t>(count);
    registers_[fifo + 8] =
        static_cast<std::uint16_t>((first + count <= newest ? 2 : 0) + (running_opcode_ == 7 ? 0 : 4));
    put32(fifo + 10, first * 1000U);
    set_crc(fifo, 13 + 8 * count, 12);
    refresh_status();
}

void ScriptedMachine::refresh_status() {
    const bool moving = running_opcode_ != 0;
    registers_[status + 2] = static_cast<std::uint16_t>((registers_[status + 2] & 3U) | (moving ? 8U : 0U));
    registers_[status + 15] = path_id_;
    put32(status + 16, static_cast<std::uint32_t>(passed_));
    put32(status + 18, static_cast<std::uint32_t>(path_.size()));
    put32(status + 20, static_cast<std::uint32_t>(samples_.size()));
    put32(status + 22, acknowledged_);
    registers_[status + 30] = static_cast<std::uint16_t>(samples_.size() - acknowledged_);
    put32(status + 34, owner_);
    set_crc(status, 37, 36);
}

void ScriptedMachine::set_crc(std::size_t first, std::size_t count, std::size_t at) {
    std::vector<std::uint16_t> covered;
    for (std::size_t k = 0; k < count; ++k) {
        if (k != at) covered.push_back(registers_[first + k]);
    }
    registers_[first + at] = crc_of(covered);
}

void ScriptedMachine::put32(std::size_t at, std::uint32_t value) {
    registers_[at] = static_cast<std::uint16_t>(value / 65536);
    registers_[at + 1] = static_cast<std::uint16_t>(value % 65536);
}

std::uint32_t ScriptedMachine::get32(std::size_t at) const {
    return registers_[at] * 65536U + registers_[at + 1];
}

}  // namespace cmm::drivers::test
