// SPDX-License-Identifier: Apache-2.0
// What clients may send to the simulated controller: Modbus TCP, Modbus RTU and lines.
#include <array>
#include <cstdlib>

#include "sim/line_codec.hpp"
#include "sim/modbus_wire.hpp"

namespace {

using namespace cmm::sim;

class Registers final : public RegisterDevice {
  public:
    ModbusException read(std::size_t address, std::span<std::uint16_t> to) override {
        if (address + to.size() > values_.size()) return ModbusException::illegal_address;
        for (std::size_t k = 0; k < to.size(); ++k)
            to[k] = values_[address + k];
        return ModbusException::none;
    }
    ModbusException write(std::size_t address, std::span<const std::uint16_t> from) override {
        if (address + from.size() > values_.size()) return ModbusException::illegal_address;
        for (std::size_t k = 0; k < from.size(); ++k)
            values_[address + k] = from[k];
        return ModbusException::none;
    }

  private:
    std::array<std::uint16_t, 512> values_{};
};

void play(WireProtocol& protocol, std::span<const std::uint8_t> bytes) {
    std::vector<std::uint8_t> out;
    while (!bytes.empty()) {
        const auto progress = protocol.answer(bytes, RtuProtocol::silence, out);
        if (progress.used > bytes.size()) std::abort();
        if (progress.used == 0 || !progress.alive) return;
        bytes = bytes.subspan(progress.used);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::span<const std::uint8_t> bytes(data, size);
    Registers registers;
    MbapProtocol over_tcp(registers);
    RtuProtocol over_rtu(registers, 1);
    play(over_tcp, bytes);
    play(over_rtu, bytes);
    std::vector<std::uint8_t> reply;
    if (!bytes.empty()) answer_pdu(registers, bytes, reply);
    const std::string line(bytes.begin(), bytes.end());
    if (const auto command = read_line_command(line))
        for (const std::string& word : command->arguments)
            static_cast<void>(line_number(word));
    return 0;
}
