// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/tcp_link.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace cmm::drivers::modbus {

TcpLink::TcpLink(std::string host, std::uint16_t port, std::uint8_t unit)
    : host_(std::move(host)), port_(std::to_string(port)), unit_(unit) {}

std::string TcpLink::open(double timeout_ms) {
    filled_ = taken_ = 0;
    return context_.open_tcp(host_, port_, timeout_ms);
}

void TcpLink::close() noexcept {
    filled_ = taken_ = 0;
    context_.close();
}

std::span<const std::uint8_t> TcpLink::send(std::uint16_t id, std::span<const std::uint8_t> pdu, bool more) {
    const auto bytes = std::span<const std::uint8_t>(sent_).first(tcp_frame(id, unit_, pdu, sent_));
    return send_to_socket(fd(), bytes, more) ? bytes : std::span<const std::uint8_t>();
}

/// False: the link is gone. Nothing there yet is no reason.
bool TcpLink::read_some() noexcept {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(taken_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(filled_), buffer_.begin());
    filled_ -= taken_;
    taken_ = 0;
    const auto room = std::span(buffer_).subspan(filled_);
    const auto got = ::recv(fd(), room.data(), room.size(), MSG_DONTWAIT);
    if (got > 0) filled_ += static_cast<std::size_t>(got);
    return got > 0 || (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR));
}

Arrival TcpLink::receive() {
    Arrival arrival;
    TcpCut cut = cut_tcp(waiting());
    // At most a part of a reply is left, so there is room for many.
    if (cut.kind == TcpCut::Kind::part) {
        if (!read_some()) {
            arrival.kind = Arrival::Kind::broken;
            return arrival;
        }
        cut = cut_tcp(waiting());
    }
    if (cut.kind == TcpCut::Kind::part) return arrival;
    if (cut.kind == TcpCut::Kind::garbled) {
        arrival.kind = Arrival::Kind::garbled;
        arrival.bytes = waiting();
        return arrival;
    }
    arrival.kind = Arrival::Kind::reply;
    arrival.bytes = waiting().first(cut.size);
    arrival.id = tcp_id(arrival.bytes);
    arrival.pdu = tcp_pdu(arrival.bytes);
    taken_ += cut.size;
    return arrival;
}

}  // namespace cmm::drivers::modbus
