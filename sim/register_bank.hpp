// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "sim/controller.hpp"
#include "sim/modbus_codec.hpp"
#include "sim/register_map.hpp"

namespace cmm::sim {

/// The controller as holding registers (docs/protocol-modbus.md). Lives on the controller's thread and not longer than
/// it.
class RegisterBank final : public RegisterDevice {
  public:
    RegisterBank(Controller& controller, const RegisterMap& map);

    ModbusException read(std::size_t address, std::span<std::uint16_t> to) override;
    ModbusException write(std::size_t address, std::span<const std::uint16_t> from) override;

  private:
    using Image = std::vector<std::uint16_t>;
    Image identity() const;
    void fill_status(std::span<std::uint16_t> to) const;
    void fill_fifo(std::span<std::uint16_t> to) const;
    ModbusException write_command(std::span<const std::uint16_t> from);
    ModbusException write_stop(std::uint16_t kind);
    ModbusException write_path(std::span<const std::uint16_t> from);
    ModbusException write_exchange(std::size_t offset, std::span<const std::uint16_t> from);
    PathPoint path_point(std::span<const std::uint16_t> registers) const;

    Controller& controller_;
    RegisterMap map_;
    Image command_, stop_, path_, exchange_;  // as last written
};

}  // namespace cmm::sim
