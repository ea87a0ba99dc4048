// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/served_bar.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sim/line_protocol.hpp"
#include "sim/modbus_wire.hpp"

namespace cmm::sim::test {
namespace {

constexpr int deadline_ms = 5000;

ControllerOptions options_at(double speed) {
    ControllerOptions options = bar_options();
    options.speed = speed;
    options.part.noise_mm = 0.0005;
    return options;
}

std::unique_ptr<WireServer> new_server() {
    auto server = WireServer::make();
    if (!server) throw std::runtime_error(server.error().text());
    return std::move(*server);
}

}  // namespace

RegisterMap repository_map() {
    auto map = load_register_map("config/maps/cmm-v1.toml");
    if (!map) throw std::runtime_error(map.error().text());
    return *map;
}

ServedBar::ServedBar(double speed) : controller_(options_at(speed), clock_), bank_(controller_, repository_map()) {
    server_ = new_server();
    const auto bound = server_->listen("127.0.0.1", 0, [this] { return std::make_unique<MbapProtocol>(bank_); });
    if (!bound) throw std::runtime_error(bound.error().text());
    port_ = *bound;
    serve();
}

ServedBar::ServedBar(const SerialLine& line, Speaks speaks)
    : controller_(options_at(0.0), clock_), bank_(controller_, repository_map()) {
    server_ = new_server();
    const auto speak = [this, speaks]() -> std::unique_ptr<WireProtocol> {
        if (speaks == Speaks::line) return std::make_unique<LineProtocol>(controller_);
        return std::make_unique<RtuProtocol>(bank_, 1);
    };
    const auto opened = server_->open(line, speak);
    if (!opened) throw std::runtime_error(opened.error().text());
    serve();
}

void ServedBar::serve() {
    thread_ = std::thread([this] { server_->run([this] { return controller_.step() ? 0 : 1; }); });
}

ServedBar::~ServedBar() {
    server_->stop();
    thread_.join();
}

RawClient::RawClient(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_port = htons(port);
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, static_cast<sockaddr*>(static_cast<void*>(&name)), sizeof name), 0);
}

RawClient::~RawClient() {
    ::close(socket_);
}

void RawClient::send(const std::vector<std::uint8_t>& bytes) {
    ASSERT_EQ(::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
}

std::vector<std::uint8_t> RawClient::receive(std::size_t count) {
    std::vector<std::uint8_t> bytes;
    while (bytes.size() < count) {
        pollfd waiting{socket_, POLLIN, 0};
        if (::poll(&waiting, 1, deadline_ms) <= 0) break;
        std::vector<std::uint8_t> part(count - bytes.size());
        const ssize_t got = ::recv(socket_, part.data(), part.size(), 0);
        if (got <= 0) break;
        bytes.insert(bytes.end(), part.begin(), part.begin() + got);
    }
    return bytes;
}

bool RawClient::closed() {
    pollfd waiting{socket_, POLLIN, 0};
    std::uint8_t byte = 0;
    return ::poll(&waiting, 1, deadline_ms) > 0 && ::recv(socket_, &byte, 1, 0) <= 0;
}

}  // namespace cmm::sim::test
