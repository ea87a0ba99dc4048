// SPDX-License-Identifier: Apache-2.0
#include "tests/support/serial_gateway.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace cmm::test {
namespace {

bool pass(int from, int to) {
    std::array<std::uint8_t, 1024> buffer;
    const auto got = ::read(from, buffer.data(), buffer.size());
    return got > 0 && ::write(to, buffer.data(), static_cast<std::size_t>(got)) == got;
}

}  // namespace

SerialGateway::SerialGateway(const std::string& serial_port)
    : serial_(::open(serial_port.c_str(), O_RDWR | O_NOCTTY)),
      listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof name;
    auto* address = static_cast<sockaddr*>(static_cast<void*>(&name));
    if (serial_ < 0 || ::bind(listener_, address, size) != 0 || ::listen(listener_, 4) != 0) {
        throw std::runtime_error("the gateway cannot start");
    }
    ::getsockname(listener_, address, &size);
    port_ = ntohs(name.sin_port);
    thread_ = std::thread([this] { serve(); });
}

SerialGateway::~SerialGateway() {
    quit_ = true;
    thread_.join();
    ::close(serial_);
    ::close(listener_);
}

void SerialGateway::serve() {
    int client = -1;
    while (!quit_) {
        std::array<pollfd, 3> wait{{{listener_, POLLIN, 0}, {serial_, POLLIN, 0}, {client, POLLIN, 0}}};
        ::poll(wait.data(), wait.size(), 10);
        if (wait[0].revents != 0) {
            if (client >= 0) ::close(client);
            client = ::accept(listener_, nullptr, nullptr);
            continue;
        }
        bool alive = true;
        if (wait[1].revents != 0 && client >= 0) alive = pass(serial_, client);
        if (wait[2].revents != 0) alive = pass(client, serial_) && alive;
        if (alive || client < 0) continue;
        ::close(client);
        client = -1;
    }
    if (client >= 0) ::close(client);
}

}  // namespace cmm::test
