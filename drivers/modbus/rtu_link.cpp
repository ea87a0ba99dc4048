// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/rtu_link.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <thread>

#include "drivers/modbus/rtu_frame.hpp"

namespace cmm::drivers::modbus {
namespace {

constexpr int silence_ms = 20;  // longer than an adapter holds bytes back
constexpr auto longest_resync = std::chrono::milliseconds(100);

}  // namespace

double RtuOptions::standard_gap_ms(const SerialSettings& serial) noexcept {
    constexpr double fixed_ms = 1.75;
    return serial.baud > 19'200 ? fixed_ms : 3.5 * serial.byte_ms();
}

std::string RtuLink::open(double timeout_ms) {
    filled_ = taken_ = 0;
    quiet_from_ = SteadyClock::now();
    if (on_serial()) return context_.open_serial(options_.serial, options_.rts, options_.unit);
    return context_.open_tcp(options_.host, std::to_string(options_.port), timeout_ms);
}

std::span<const std::uint8_t> RtuLink::send(std::uint16_t id, std::span<const std::uint8_t> pdu, bool /*more*/) {
    const std::chrono::duration<double, std::milli> gap(options_.gap_ms);
    std::this_thread::sleep_until(quiet_from_ + std::chrono::ceil<SteadyClock::duration>(gap));
    discard_input();  // what came before the request is no reply to it
    sent_id_ = id;
    const std::size_t size = rtu_frame(options_.unit, pdu, sent_);
    const auto frame = std::span(sent_).first(size);
    const bool sent = on_serial() ? context_.send_serial(frame.first(size - 2)) : send_to_socket(fd(), frame);
    return sent ? frame : std::span<std::uint8_t>();
}

bool RtuLink::readable(int timeout_ms) const noexcept {
    pollfd wait{fd(), POLLIN, 0};
    return ::poll(&wait, 1, timeout_ms) > 0;
}

void RtuLink::discard_input() noexcept {
    do {
        filled_ = taken_ = 0;
    } while (readable(0) && read_some() && filled_ > 0);
}

/// False: the link is gone.
bool RtuLink::read_some() noexcept {
    const auto room = std::span(buffer_).subspan(filled_);
    const auto got = ::read(fd(), room.data(), room.size());
    if (got > 0) {
        filled_ += static_cast<std::size_t>(got);
        quiet_from_ = SteadyClock::now();
    }
    return got > 0 || (got < 0 && (errno == EAGAIN || errno == EINTR));
}

void RtuLink::drop(std::size_t bytes) noexcept {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(bytes),
              buffer_.begin() + static_cast<std::ptrdiff_t>(filled_), buffer_.begin());
    filled_ -= bytes;
}

Arrival RtuLink::receive() {
    drop(taken_);
    taken_ = 0;
    Arrival arrival;
    if (readable(0) && !read_some()) {
        arrival.kind = Arrival::Kind::broken;
        return arrival;
    }
    RtuCut cut;
    while ((cut = cut_rtu(received(), options_.unit)).kind == RtuCut::Kind::foreign)
        drop(cut.size);
    if (cut.kind == RtuCut::Kind::garbled) {
        arrival.kind = Arrival::Kind::garbled;
        arrival.bytes = received();
    } else if (cut.kind == RtuCut::Kind::reply) {
        arrival.kind = Arrival::Kind::reply;
        arrival.id = sent_id_;
        arrival.pdu = cut.pdu;
        arrival.bytes = received().first(cut.size);
        taken_ = cut.size;
    }
    return arrival;
}

/// Throws away what arrives until the line is silent: then the next byte begins a frame.
bool RtuLink::resync() {
    const auto give_up = SteadyClock::now() + longest_resync;
    for (;;) {
        filled_ = taken_ = 0;
        if (!readable(silence_ms)) return true;
        if (!read_some() || SteadyClock::now() > give_up) return false;
    }
}

double RtuLink::wire_ms(std::size_t bytes) const noexcept {
    return options_.gap_ms + static_cast<double>(bytes) * options_.serial.byte_ms();
}

}  // namespace cmm::drivers::modbus
