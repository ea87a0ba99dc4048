// SPDX-License-Identifier: Apache-2.0
#include "tests/support/distant_network.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <stdexcept>

namespace cmm::test {
namespace {

using namespace std::chrono_literals;

constexpr auto look_up_every = 20ms;  // to see that it shall end

sockaddr_in on_this_host(std::uint16_t port) {
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    name.sin_port = htons(port);
    return name;
}

sockaddr* generic(sockaddr_in& name) {
    return static_cast<sockaddr*>(static_cast<void*>(&name));
}

void send_at_once(int fd) {
    const int on = 1;
    ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

}  // namespace

DistantNetwork::DistantNetwork(std::uint16_t server_port, Clock::duration one_way)
    : server_port_(server_port), one_way_(one_way), listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in name = on_this_host(0);
    socklen_t size = sizeof name;
    if (listener_ < 0 || ::bind(listener_, generic(name), size) != 0 || ::listen(listener_, 8) != 0) {
        throw std::runtime_error("the network between client and server cannot start");
    }
    ::getsockname(listener_, generic(name), &size);
    port_ = ntohs(name.sin_port);
    thread_ = std::thread([this] { serve(); });
}

DistantNetwork::~DistantNetwork() {
    quit_ = true;
    thread_.join();
    for (Connection& connection : connections_)
        connection.alive = false;
    close_dead();
    ::close(listener_);
}

std::string DistantNetwork::modbus_url(const std::string& options) const {
    return "modbus+tcp://127.0.0.1:" + std::to_string(port_) + "?" + options;
}

void DistantNetwork::accept_client() {
    const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) return;
    const int server = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in name = on_this_host(server_port_);
    if (server < 0 || ::connect(server, generic(name), sizeof name) != 0) {
        if (server >= 0) ::close(server);
        ::close(client);
        return;
    }
    send_at_once(client);
    send_at_once(server);
    connections_.push_back({{client, server, false, {}}, {server, client, false, {}}, true});
}

void DistantNetwork::take(Direction& direction) const {
    std::array<std::uint8_t, 64 * 1024> buffer;
    const auto got = ::recv(direction.from, buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (got < 0) return;
    direction.ended = got == 0;
    direction.under_way.push_back({Clock::now() + one_way_, {buffer.begin(), buffer.begin() + got}});
}

/// False: nothing can come any more.
bool DistantNetwork::deliver(Direction& direction) {
    while (!direction.under_way.empty() && direction.under_way.front().due <= Clock::now()) {
        const auto& bytes = direction.under_way.front().bytes;
        if (bytes.empty()) return false;
        if (::send(direction.to, bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0) return false;
        direction.under_way.pop_front();
    }
    return true;
}

void DistantNetwork::close_dead() {
    const auto closed = [](Connection& connection) {
        if (connection.alive) return false;
        ::close(connection.there.from);
        ::close(connection.there.to);
        return true;
    };
    connections_.remove_if(closed);
}

void DistantNetwork::serve() {
    while (!quit_) {
        std::vector<pollfd> watched{{listener_, POLLIN, 0}};
        auto next = Clock::now() + look_up_every;
        for (const Connection& connection : connections_) {
            for (const Direction* direction : {&connection.there, &connection.back}) {
                watched.push_back({direction->ended ? -1 : direction->from, POLLIN, 0});
                if (!direction->under_way.empty()) next = std::min(next, direction->under_way.front().due);
            }
        }
        const auto wait = std::max<Clock::duration>(next - Clock::now(), Clock::duration::zero());
        const timespec timeout{0, std::chrono::nanoseconds(wait).count()};
        ::ppoll(watched.data(), watched.size(), &timeout, nullptr);
        std::size_t at = 1;
        for (Connection& connection : connections_) {
            for (Direction* direction : {&connection.there, &connection.back}) {
                if (watched[at++].revents != 0) take(*direction);
                if (!deliver(*direction)) connection.alive = false;
            }
        }
        close_dead();
        if (watched[0].revents != 0) accept_client();
    }
}

}  // namespace cmm::test
