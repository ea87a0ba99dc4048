// SPDX-License-Identifier: Apache-2.0
// What a PLC, or whoever takes its place, may send to the cell.
#include <algorithm>
#include <array>
#include <cstdlib>

#include "cell/modbus_request.hpp"
#include "cell/registers.hpp"

namespace {

using namespace cmm::cell;

class Registers final : public RegisterAccess {
  public:
    ModbusException read(std::size_t address, std::span<std::uint16_t> to) override {
        if (to.empty() || to.size() > 125) std::abort();
        return read_registers(plc_, cell_, address, to);
    }
    ModbusException write(std::size_t address, std::span<const std::uint16_t> from) override {
        if (from.empty() || from.size() > 123) std::abort();
        const auto before = plc_.words;
        const auto outcome = write_registers(plc_, address, from);
        if (outcome != ModbusException::none && plc_.words != before) std::abort();
        if ((plc_.words[PlcBlock::command] & ~command_bit::all) != 0) std::abort();
        const auto serial = plc_.serial_text();
        if (serial.size() > longest_serial) std::abort();
        static_cast<void>(is_serial(serial));
        return outcome;
    }

  private:
    PlcBlock plc_;
    CellBlock cell_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::span<const std::uint8_t> bytes(data, size);
    Registers registers;
    std::array<std::uint8_t, longest_adu> reply{};
    for (auto cut = cut_request(bytes); cut.kind == RequestCut::Kind::request; cut = cut_request(bytes)) {
        if (cut.size > bytes.size() || cut.size > longest_adu) std::abort();
        const auto request = bytes.first(cut.size);
        const std::size_t answered = answer_request(registers, 1, request, reply);
        // A reply says its own length, names its request, and is one of Modbus.
        if (answered < 9 || answered > longest_adu || reply[5] != answered - 6 || reply[4] != 0) std::abort();
        if (!std::equal(request.begin(), request.begin() + 2, reply.begin())) std::abort();
        if ((reply[7] | 0x80) != (request[7] | 0x80)) std::abort();
        bytes = bytes.subspan(cut.size);
    }
    return 0;
}
