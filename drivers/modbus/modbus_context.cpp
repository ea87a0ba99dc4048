// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/modbus_context.hpp"

#include <modbus/modbus.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>

namespace cmm::drivers::modbus {
namespace {

using SteadyClock = std::chrono::steady_clock;

// A controller that does not take in 260 bytes for so long is as good as gone.
constexpr auto longest_send = std::chrono::milliseconds(200);

/// libmodbus waits by select(): a descriptor from 1024 on would overwrite its stack. The next free number tells before
/// it is used.
bool descriptors_left() {
    const int probe = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (probe < 0) return false;
    ::close(probe);
    return probe < FD_SETSIZE;
}

std::string reason(int error, double timeout_ms) {
    if (error == EMFILE) return "this process has too many files open";
    // A timed-out connect leaves the error of the non-blocking call behind.
    if (error == ETIMEDOUT || error == EINPROGRESS) {
        return "no answer within " + std::to_string(static_cast<int>(timeout_ms)) + " ms";
    }
    return std::strerror(error);
}

/// libmodbus reports an unknown name as a refused connection: ask again to tell them apart.
std::string tcp_failure(const std::string& host, const std::string& port, int error, double timeout_ms) {
    const std::string what = "cannot connect to " + host + ":" + port + ": ";
    addrinfo* found = nullptr;
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    const int resolved = ::getaddrinfo(host.c_str(), nullptr, &hints, &found);
    if (found != nullptr) ::freeaddrinfo(found);
    return what + (resolved != 0 ? ::gai_strerror(resolved) : reason(error, timeout_ms));
}

std::string serial_failure(const std::string& device, int error) {
    const std::string what = "cannot open " + device + ": " + reason(error, 0.0);
    if (error == EACCES) return what + " (the user must belong to the group that owns the port, usually dialout)";
    return what;
}

char letter_of(Parity parity) {
    if (parity == Parity::even) return 'E';
    return parity == Parity::odd ? 'O' : 'N';
}

}  // namespace

struct ModbusContext::Handle {
    explicit Handle(modbus_t* made) : modbus(made) {}
    ~Handle() {
        modbus_close(modbus);
        modbus_free(modbus);
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    modbus_t* modbus;
};

ModbusContext::ModbusContext() = default;
ModbusContext::~ModbusContext() = default;

std::string ModbusContext::open_tcp(const std::string& host, const std::string& port, double timeout_ms) {
    close();
    if (!descriptors_left()) return tcp_failure(host, port, EMFILE, timeout_ms);
    modbus_t* made = modbus_new_tcp_pi(host.c_str(), port.c_str());
    if (made == nullptr) return tcp_failure(host, port, errno, timeout_ms);
    handle_ = std::make_unique<Handle>(made);
    const auto us = static_cast<std::uint32_t>(timeout_ms * 1000.0);
    modbus_set_response_timeout(made, us / 1'000'000U, us % 1'000'000U);
    if (modbus_connect(made) != 0) {
        std::string why = tcp_failure(host, port, errno, timeout_ms);
        close();
        return why;
    }
    const int on = 1;
    ::setsockopt(fd(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);  // not done by libmodbus for IPv6
    return {};
}

std::string ModbusContext::open_serial(const SerialSettings& serial, const RtsHandling& rts, std::uint8_t unit) {
    close();
    if (!descriptors_left()) return serial_failure(serial.device, EMFILE);
    modbus_t* made = modbus_new_rtu(serial.device.c_str(), serial.baud, letter_of(serial.parity), 8, serial.stop_bits);
    if (made == nullptr) return serial_failure(serial.device, errno);
    handle_ = std::make_unique<Handle>(made);
    modbus_set_slave(made, unit);
    if (modbus_connect(made) != 0) {
        std::string why = serial_failure(serial.device, errno);
        close();
        return why;
    }
    if (rts.while_sending != RtsHandling::Level::none) {
        const bool up = rts.while_sending == RtsHandling::Level::up;
        if (rts.delay_us > 0) modbus_rtu_set_rts_delay(made, rts.delay_us);
        modbus_rtu_set_rts(made, up ? MODBUS_RTU_RTS_UP : MODBUS_RTU_RTS_DOWN);
    }
    modbus_flush(made);  // what others left in the port is not for us
    return {};
}

void ModbusContext::close() noexcept {
    handle_.reset();
}

bool ModbusContext::is_open() const noexcept {
    return handle_ != nullptr;
}

int ModbusContext::fd() const noexcept {
    return modbus_get_socket(handle_->modbus);
}

bool ModbusContext::send_serial(std::span<std::uint8_t> unit_and_pdu) {
    return modbus_send_raw_request(handle_->modbus, unit_and_pdu.data(), static_cast<int>(unit_and_pdu.size())) > 0;
}

bool send_to_socket(int fd, std::span<const std::uint8_t> bytes, bool more) {
    const int flags = MSG_NOSIGNAL | (more ? MSG_MORE : 0);
    const auto deadline = SteadyClock::now() + longest_send;
    while (!bytes.empty()) {
        const auto sent = ::send(fd, bytes.data(), bytes.size(), flags);
        if (sent > 0) {
            bytes = bytes.subspan(static_cast<std::size_t>(sent));
        } else if (errno == EAGAIN && SteadyClock::now() < deadline) {
            pollfd wait{fd, POLLOUT, 0};
            ::poll(&wait, 1, 10);
        } else if (errno != EINTR) {
            return false;
        }
    }
    return true;
}

}  // namespace cmm::drivers::modbus
