// SPDX-License-Identifier: Apache-2.0
// What a Modbus controller may answer: TCP frames, and registers of every block under both maps' word orders.
#include <array>
#include <cstring>
#include <vector>

#include "drivers/modbus/blocks.hpp"
#include "drivers/modbus/frame.hpp"

namespace {

using namespace cmm::drivers::modbus;

void decode_blocks(const RegisterMap& map, std::span<const std::uint16_t> registers) {
    static_cast<void>(decode_identity(map, registers.first(map.identity.length)));
    const auto status = registers.first(map.status.length);
    if (check_status(map, status)) static_cast<void>(decode_status(map, status));
    const auto fifo = registers.first(map.fifo.length);
    if (!check_fifo(map, fifo)) return;
    std::vector<cmm::core::Sample> samples;
    decode_samples(map, fifo, decode_fifo(map, fifo), samples);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::span<const std::uint8_t> bytes(data, size);
    for (const auto kind : {Transaction::Kind::read, Transaction::Kind::write, Transaction::Kind::exchange}) {
        Transaction request;
        request.kind = kind;
        request.read_count = static_cast<std::uint16_t>(size % (max_read + 1));
        request.write_count = 5;
        const TcpCut cut = cut_tcp(bytes);
        if (cut.kind == TcpCut::Kind::frame) take_reply(tcp_pdu(bytes.first(cut.size)), request);
        take_reply(bytes, request);
    }
    std::array<std::uint16_t, max_read> registers{};
    std::memcpy(registers.data(), data, std::min(size, sizeof registers));
    RegisterMap map;
    decode_blocks(map, registers);
    // Past the checksums: a fuzzer does not guess them.
    if (registers[map.fifo.count] <= 14) {
        const auto used = std::span(registers).first(map.fifo.points + std::size_t{registers[map.fifo.count]} * 8);
        registers[map.fifo.crc] = crc16(used, map.fifo.crc);
    }
    map.high_word_first = false;
    decode_blocks(map, registers);
    return 0;
}
