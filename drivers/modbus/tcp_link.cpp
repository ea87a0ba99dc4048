// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/tcp_link.hpp"

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
#include <utility>

namespace cmm::drivers::modbus {
namespace {

using SteadyClock = std::chrono::steady_clock;

// A frame arrives in one segment but for rare splits; longer gaps inside it count as a broken link. Below 50 ms,
// because a stop waits for the frame being received.
constexpr std::uint32_t byte_timeout_us = 40'000;

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

}  // namespace

/// Error recovery stays off: with it libmodbus loops inside send for as long as the server is gone.
struct TcpLink::Context {
    explicit Context(modbus_t* made) : modbus(made) {}
    ~Context() {
        modbus_close(modbus);
        modbus_free(modbus);
    }
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;
    modbus_t* modbus;
};

TcpLink::TcpLink(std::string host, std::uint16_t port) : host_(std::move(host)), port_(std::to_string(port)) {}
TcpLink::~TcpLink() = default;

std::string TcpLink::open(double timeout_ms) {
    close();
    if (!descriptors_left()) return failure(EMFILE, timeout_ms);
    modbus_t* made = modbus_new_tcp_pi(host_.c_str(), port_.c_str());
    if (made == nullptr) return failure(errno, timeout_ms);
    context_ = std::make_unique<Context>(made);
    const auto us = static_cast<std::uint32_t>(timeout_ms * 1000.0);
    modbus_set_response_timeout(made, us / 1'000'000U, us % 1'000'000U);
    modbus_set_byte_timeout(made, 0, byte_timeout_us);
    if (modbus_connect(made) != 0) {
        std::string why = failure(errno, timeout_ms);
        close();
        return why;
    }
    const int on = 1;
    ::setsockopt(fd(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);  // not done by libmodbus for IPv6
    return {};
}

/// libmodbus reports an unknown name as a refused connection: ask again to tell them apart.
std::string TcpLink::failure(int error, double timeout_ms) const {
    const std::string what = "cannot connect to " + host_ + ":" + port_ + ": ";
    addrinfo* found = nullptr;
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    const int resolved = ::getaddrinfo(host_.c_str(), nullptr, &hints, &found);
    if (found != nullptr) ::freeaddrinfo(found);
    if (resolved != 0) return what + ::gai_strerror(resolved);
    if (error == EMFILE) return what + "this process has too many files open";
    // A timed-out connect leaves the error of the non-blocking call behind.
    if (error == ETIMEDOUT || error == EINPROGRESS) {
        return what + "no answer within " + std::to_string(static_cast<int>(timeout_ms)) + " ms";
    }
    return what + std::strerror(error);
}

void TcpLink::close() noexcept {
    context_.reset();
}

int TcpLink::fd() const noexcept {
    return modbus_get_socket(context_->modbus);
}

bool TcpLink::send(std::span<const std::uint8_t> frame) {
    const auto deadline = SteadyClock::now() + longest_send;
    while (!frame.empty()) {
        const auto sent = ::send(fd(), frame.data(), frame.size(), MSG_NOSIGNAL);
        if (sent > 0) {
            frame = frame.subspan(static_cast<std::size_t>(sent));
        } else if (errno == EAGAIN && SteadyClock::now() < deadline) {
            pollfd wait{fd(), POLLOUT, 0};
            ::poll(&wait, 1, 10);
        } else if (errno != EINTR) {
            return false;
        }
    }
    return true;
}

std::span<const std::uint8_t> TcpLink::receive() {
    const int size = modbus_receive_confirmation(context_->modbus, frame_.data());
    if (size <= 0) return {};
    return {frame_.data(), static_cast<std::size_t>(size)};
}

}  // namespace cmm::drivers::modbus
