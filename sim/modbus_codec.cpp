// SPDX-License-Identifier: Apache-2.0
#include "sim/modbus_codec.hpp"

#include <array>

namespace cmm::sim {
namespace {

constexpr std::size_t most_read = 125;        // Modbus application protocol 1.1b3, 6.3
constexpr std::size_t most_written = 123;     // 6.12
constexpr std::size_t most_written_23 = 121;  // 6.17

std::uint16_t word(std::span<const std::uint8_t> bytes, std::size_t at) {
    return static_cast<std::uint16_t>(bytes[at] << 8U | bytes[at + 1]);
}

void append_word(std::vector<std::uint8_t>& to, std::uint16_t value) {
    to.push_back(static_cast<std::uint8_t>(value >> 8U));
    to.push_back(static_cast<std::uint8_t>(value & 0xFFU));
}

using Exception = ModbusException;

Exception read_into(RegisterDevice& device, std::size_t address, std::size_t count, std::vector<std::uint8_t>& reply) {
    if (count < 1 || count > most_read) return Exception::illegal_value;
    if (address + count > 65536) return Exception::illegal_address;
    std::array<std::uint16_t, most_read> values{};
    const std::span<std::uint16_t> wanted(values.data(), count);
    const Exception outcome = device.read(address, wanted);
    if (outcome != Exception::none) return outcome;
    reply.push_back(static_cast<std::uint8_t>(2 * count));
    for (const std::uint16_t value : wanted)
        append_word(reply, value);
    return Exception::none;
}

/// The write part of FC 16 and FC 23: address, count, byte count, values, up to the end of the PDU.
Exception write_block(RegisterDevice& device, std::span<const std::uint8_t> part, std::size_t most) {
    if (part.size() < 5) return Exception::illegal_value;
    const std::size_t address = word(part, 0);
    const std::size_t count = word(part, 2);
    if (count < 1 || count > most || part[4] != 2 * count || part.size() != 5 + 2 * count)
        return Exception::illegal_value;
    if (address + count > 65536) return Exception::illegal_address;
    std::array<std::uint16_t, most_written> values{};
    for (std::size_t i = 0; i < count; ++i)
        values[i] = word(part, 5 + 2 * i);
    return device.write(address, std::span<const std::uint16_t>(values.data(), count));
}

Exception carry_out(RegisterDevice& device, std::span<const std::uint8_t> request, std::vector<std::uint8_t>& reply) {
    switch (request[0]) {
        case 3:
        case 4:
            if (request.size() != 5) return Exception::illegal_value;
            return read_into(device, word(request, 1), word(request, 3), reply);
        case 6: {
            if (request.size() != 5) return Exception::illegal_value;
            const std::array<std::uint16_t, 1> value{word(request, 3)};
            const Exception outcome = device.write(word(request, 1), value);
            if (outcome == Exception::none) reply.insert(reply.end(), request.begin() + 1, request.end());
            return outcome;
        }
        case 16: {
            const Exception outcome = write_block(device, request.subspan(1), most_written);
            if (outcome == Exception::none) reply.insert(reply.end(), request.begin() + 1, request.begin() + 5);
            return outcome;
        }
        case 23: {
            if (request.size() < 10) return Exception::illegal_value;
            const std::size_t wanted = word(request, 3);
            if (wanted < 1 || wanted > most_read) return Exception::illegal_value;  // before anything is written
            const Exception outcome = write_block(device, request.subspan(5), most_written_23);
            return outcome == Exception::none ? read_into(device, word(request, 1), wanted, reply) : outcome;
        }
        default:
            return Exception::illegal_function;
    }
}

}  // namespace

mbap::Parse mbap::next_frame(std::span<const std::uint8_t> bytes, Frame& frame) {
    if (bytes.size() >= 4 && word(bytes, 2) != 0) return Parse::malformed;
    if (bytes.size() < header) return Parse::partial;
    const std::size_t length = word(bytes, 4);  // unit and PDU
    if (length < 2 || length > 1 + longest_pdu) return Parse::malformed;
    frame.size = header - 1 + length;
    if (bytes.size() < frame.size) return Parse::partial;
    frame.header = bytes.first(header);
    frame.pdu = bytes.subspan(header, length - 1);
    return Parse::complete;
}

void answer_pdu(RegisterDevice& device, std::span<const std::uint8_t> request, std::vector<std::uint8_t>& reply) {
    const std::size_t start = reply.size();
    reply.push_back(request[0]);
    const Exception outcome = carry_out(device, request, reply);
    if (outcome == Exception::none) return;
    reply.resize(start);
    reply.push_back(static_cast<std::uint8_t>(request[0] | 0x80U));
    reply.push_back(static_cast<std::uint8_t>(outcome));
}

void answer_frame(RegisterDevice& device, const mbap::Frame& frame, std::vector<std::uint8_t>& reply) {
    const std::size_t start = reply.size();
    reply.insert(reply.end(), frame.header.begin(), frame.header.end());
    answer_pdu(device, frame.pdu, reply);
    const std::size_t length = reply.size() - start - (mbap::header - 1);
    reply[start + 4] = static_cast<std::uint8_t>(length >> 8U);
    reply[start + 5] = static_cast<std::uint8_t>(length & 0xFFU);
}

}  // namespace cmm::sim
