// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/serial_wire.hpp"

#include <termios.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>
#include <utility>

namespace cmm::drivers::line {
namespace {

namespace asio = boost::asio;
using Error = boost::system::error_code;
using Port = asio::serial_port_base;

Port::parity parity_of(Parity parity) {
    if (parity == Parity::even) return Port::parity(Port::parity::even);
    return Port::parity(parity == Parity::odd ? Port::parity::odd : Port::parity::none);
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
    return {static_cast<const std::uint8_t*>(static_cast<const void*>(text.data())), text.size()};
}

}  // namespace

SerialWire::SerialWire(asio::io_context& io, SerialSettings settings, LinkLog& log, Events events)
    : port_(io), settings_(std::move(settings)), log_(log), events_(std::move(events)) {}

std::string SerialWire::open() {
    close();
    Error error;
    port_.open(settings_.device, error);
    std::string why = error ? error.message() : set_up();
    if (!why.empty()) {
        close();
        return "cannot open " + settings_.device + ": " + why;
    }
    ::tcflush(port_.native_handle(), TCIOFLUSH);
    read_on();
    return {};
}

std::string SerialWire::set_up() {
    const auto set = [this](const auto& option) {
        Error error;
        port_.set_option(option, error);
        return error;
    };
    Error error = set(Port::baud_rate(static_cast<unsigned>(settings_.baud)));
    if (!error) error = set(Port::character_size(static_cast<unsigned>(settings_.data_bits)));
    if (!error) error = set(Port::flow_control(Port::flow_control::none));
    if (!error) error = set(parity_of(settings_.parity));
    const auto stop_bits = settings_.stop_bits == 2 ? Port::stop_bits::two : Port::stop_bits::one;
    if (!error) error = set(Port::stop_bits(stop_bits));
    return error ? error.message() : std::string();
}

void SerialWire::close() noexcept {
    ++link_number_;
    outgoing_.clear();
    writing_ = false;
    Error ignored;
    port_.close(ignored);
}

void SerialWire::send(std::string text, bool urgent, std::function<void()> written) {
    const auto first_waiting = outgoing_.begin() + (writing_ ? 1 : 0);
    outgoing_.insert(urgent ? first_waiting : outgoing_.end(), Outgoing{std::move(text), std::move(written)});
    if (!writing_) write_on();
}

std::size_t SerialWire::waiting() const noexcept {
    std::size_t bytes = 0;
    for (const Outgoing& entry : outgoing_)
        bytes += entry.text.size();
    return bytes;
}

void SerialWire::read_on() {
    port_.async_read_some(asio::buffer(buffer_), [this, link = link_number_](const Error& error, std::size_t count) {
        if (link != link_number_) return;
        if (error) return lose();
        const auto bytes = std::span<const std::uint8_t>(buffer_).first(count);
        log_.received(bytes);
        events_.arrived(bytes);
        if (link == link_number_) read_on();
    });
}

void SerialWire::write_on() {
    if (outgoing_.empty() || !port_.is_open()) return;
    writing_ = true;
    const std::string& text = outgoing_.front().text;
    log_.sent(bytes_of(text));
    asio::async_write(port_, asio::buffer(text), [this, link = link_number_](const Error& error, std::size_t) {
        if (link != link_number_) return;
        if (error) return lose();
        const auto written = std::move(outgoing_.front().written);
        outgoing_.pop_front();
        writing_ = false;
        if (written) written();
        write_on();
    });
}

void SerialWire::lose() {
    close();
    events_.lost();
}

}  // namespace cmm::drivers::line
