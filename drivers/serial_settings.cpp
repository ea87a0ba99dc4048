// SPDX-License-Identifier: Apache-2.0
#include "drivers/serial_settings.hpp"

namespace cmm::drivers {

SerialSettings SerialSettings::of(const Endpoint& endpoint, Parity default_parity) {
    SerialSettings settings;
    settings.device = endpoint.path;
    settings.baud = static_cast<int>(endpoint.integer("baud", settings.baud));
    settings.stop_bits = static_cast<int>(endpoint.integer("stop_bits", settings.stop_bits));
    settings.data_bits = static_cast<int>(endpoint.integer("data_bits", settings.data_bits));
    settings.parity = default_parity;
    const std::string parity = endpoint.word("parity", "");
    if (parity == "none") settings.parity = Parity::none;
    if (parity == "even") settings.parity = Parity::even;
    if (parity == "odd") settings.parity = Parity::odd;
    return settings;
}

}  // namespace cmm::drivers
