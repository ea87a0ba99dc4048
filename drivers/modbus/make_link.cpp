// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/make_link.hpp"

#include <algorithm>

#include "drivers/modbus/rtu_link.hpp"
#include "drivers/modbus/tcp_link.hpp"

namespace cmm::drivers::modbus {
namespace {

RtsHandling::Level level_of(const std::string& word) {
    if (word == "up") return RtsHandling::Level::up;
    return word == "down" ? RtsHandling::Level::down : RtsHandling::Level::none;
}

RtuOptions rtu_options_of(const Endpoint& endpoint) {
    RtuOptions options;
    options.serial = SerialSettings::of(endpoint, Parity::even);
    options.rts = {level_of(endpoint.word("rts", "none")), static_cast<int>(endpoint.integer("rts_delay_us", 0))};
    options.host = endpoint.host;
    options.port = endpoint.port;
    options.unit = static_cast<std::uint8_t>(endpoint.integer("unit", 1));
    const std::int64_t gap_us = endpoint.integer("gap_us", -1);
    options.gap_ms = gap_us < 0 ? RtuOptions::standard_gap_ms(options.serial) : static_cast<double>(gap_us) * 1e-3;
    options.gap_ms = std::max(options.gap_ms, static_cast<double>(endpoint.integer("turnaround_ms", 0)));
    return options;
}

}  // namespace

std::unique_ptr<Link> make_link(const Endpoint& endpoint) {
    if (endpoint.scheme != "modbus+tcp") return std::make_unique<RtuLink>(rtu_options_of(endpoint));
    const auto unit = static_cast<std::uint8_t>(endpoint.integer("unit", 1));
    return std::make_unique<TcpLink>(endpoint.host, endpoint.port, unit);
}

}  // namespace cmm::drivers::modbus
