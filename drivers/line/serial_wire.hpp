// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/serial_port.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <string>

#include "drivers/link_log.hpp"
#include "drivers/serial_settings.hpp"

namespace cmm::drivers::line {

/// Bytes to and from a serial port by Asio: texts are written one after another, an urgent one before those that wait.
/// Used on the thread of its io_context, which outlives it.
class SerialWire {
  public:
    struct Events {
        std::function<void(std::span<const std::uint8_t>)> arrived;
        std::function<void()> lost;  ///< the port is gone and closed
    };
    SerialWire(boost::asio::io_context& io, SerialSettings settings, LinkLog& log, Events events);

    /// Returns why it failed; empty: it is open. What others left in the port is thrown away.
    std::string open();
    void close() noexcept;
    bool is_open() const noexcept { return port_.is_open(); }
    /// `written` is called when the text has been handed to the port.
    void send(std::string text, bool urgent, std::function<void()> written = {});
    double wire_ms(std::size_t bytes) const noexcept { return static_cast<double>(bytes) * settings_.byte_ms(); }
    /// Bytes that wait to be written, those of the text under way included.
    std::size_t waiting() const noexcept;

  private:
    struct Outgoing {
        std::string text;
        std::function<void()> written;
    };
    std::string set_up();
    void read_on();
    void write_on();
    void lose();

    boost::asio::serial_port port_;
    SerialSettings settings_;
    LinkLog& log_;
    Events events_;
    std::array<std::uint8_t, 4096> buffer_{};
    std::deque<Outgoing> outgoing_;
    bool writing_ = false;
    std::uint64_t link_number_ = 0;  // tells what belongs to a port that was closed since
};

}  // namespace cmm::drivers::line
