// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/tcp_link.hpp"

#include <utility>

namespace cmm::drivers::modbus {

TcpLink::TcpLink(std::string host, std::uint16_t port, std::uint8_t unit)
    : host_(std::move(host)), port_(std::to_string(port)), unit_(unit) {}

std::string TcpLink::open(double timeout_ms) {
    return context_.open_tcp(host_, port_, timeout_ms, rest_timeout_ms);
}

std::span<const std::uint8_t> TcpLink::send(std::uint16_t id, std::span<const std::uint8_t> pdu) {
    const auto bytes = std::span<const std::uint8_t>(sent_).first(tcp_frame(id, unit_, pdu, sent_));
    return send_to_socket(fd(), bytes) ? bytes : std::span<const std::uint8_t>();
}

Arrival TcpLink::receive() {
    Arrival arrival;
    arrival.bytes = std::span<const std::uint8_t>(received_).first(context_.receive_frame(received_));
    if (arrival.bytes.empty()) {
        arrival.kind = Arrival::Kind::broken;
    } else if (!tcp_header_fits(arrival.bytes)) {
        arrival.kind = Arrival::Kind::garbled;
    } else {
        arrival.kind = Arrival::Kind::reply;
        arrival.id = tcp_id(arrival.bytes);
        arrival.pdu = tcp_pdu(arrival.bytes);
    }
    return arrival;
}

}  // namespace cmm::drivers::modbus
