// SPDX-License-Identifier: Apache-2.0
#include "cell/plc_server.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <future>
#include <thread>
#include <vector>

namespace cmm::cell {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A socket that connects from an address of its own of this machine.
class Client {
  public:
    explicit Client(std::uint16_t port, const char* from = "127.0.0.1") : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in here{}, there{};
        here.sin_family = there.sin_family = AF_INET;
        ::inet_pton(AF_INET, from, &here.sin_addr);
        there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        there.sin_port = htons(port);
        if (::bind(socket_, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0 ||
            ::connect(socket_, reinterpret_cast<const sockaddr*>(&there), sizeof there) != 0)
            ADD_FAILURE() << "no connection";
    }
    ~Client() { ::close(socket_); }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    void send(const Bytes& bytes) const { ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
    /// So many bytes, or what came until the other side closed or ten seconds were over.
    Bytes receive(std::size_t count) const {
        Bytes got;
        pollfd wait{socket_, POLLIN, 0};
        while (got.size() < count && ::poll(&wait, 1, 10'000) > 0) {
            std::uint8_t byte = 0;
            if (::recv(socket_, &byte, 1, 0) <= 0) break;
            got.push_back(byte);
        }
        return got;
    }
    /// Within ten seconds.
    bool closed() const {
        pollfd wait{socket_, POLLIN, 0};
        std::uint8_t byte = 0;
        return ::poll(&wait, 1, 10'000) > 0 && ::recv(socket_, &byte, 1, 0) <= 0;
    }
    /// The exception code of a write to register 0, 0: it was written.
    int write(std::uint8_t value) const {
        send({0, 1, 0, 0, 0, 6, 1, 6, 0, 0, 0, value});
        const Bytes head = receive(9);
        if (head.size() < 9) return -1;
        if (head[7] == 0x86) return head[8];
        return receive(3).size() == 3 ? 0 : -1;
    }

  private:
    int socket_;
};

class Register final : public RegisterAccess {
  public:
    ModbusException read(std::size_t, std::span<std::uint16_t> to) override {
        std::fill(to.begin(), to.end(), value.load());
        return ModbusException::none;
    }
    ModbusException write(std::size_t, std::span<const std::uint16_t> from) override {
        value = from.front();
        return ModbusException::none;
    }
    std::atomic<std::uint16_t> value{0x1234};
};

class PlcServerTest : public ::testing::Test {
  protected:
    void start(const PlcServerOptions& options) {
        auto started = PlcServer::start(context.get_executor(), options, registers, clock);
        ASSERT_TRUE(started) << started.error().text();
        server = std::move(*started);
        thread = std::thread([this] { context.run(); });
    }
    ~PlcServerTest() override {
        context.stop();
        if (thread.joinable()) thread.join();
    }
    PlcServerCounts counts() {
        std::promise<PlcServerCounts> answer;
        boost::asio::post(context, [&] { answer.set_value(server->counts()); });
        return answer.get_future().get();
    }

    core::ManualClock clock;
    Register registers;
    boost::asio::io_context context;
    std::unique_ptr<PlcServer> server;
    std::thread thread;
};

TEST_F(PlcServerTest, AnswersRequestsThatComeInPiecesAndTogether) {
    start({});
    const Client client(server->port());
    const Bytes request{0, 7, 0, 0, 0, 6, 1, 3, 0, 0, 0, 1};
    const Bytes reply{0, 7, 0, 0, 0, 5, 1, 3, 2, 0x12, 0x34};
    for (const auto byte : request)
        client.send({byte});
    EXPECT_EQ(client.receive(11), reply);
    Bytes many;
    for (int i = 0; i < 400; ++i)
        many.insert(many.end(), request.begin(), request.end());
    client.send(many);
    const Bytes all = client.receive(400 * reply.size());
    ASSERT_EQ(all.size(), 400 * reply.size());
    EXPECT_TRUE(std::equal(reply.begin(), reply.end(), all.end() - 11));
    EXPECT_EQ(counts().requests, 401U);
}

TEST_F(PlcServerTest, WhatIsNoModbusIsClosed) {
    start({});
    const Client client(server->port());
    const std::string http = "GET / HTTP/1.1\r\nHost: a\r\n\r\n";
    client.send({http.begin(), http.end()});
    EXPECT_TRUE(client.closed());
    EXPECT_EQ(counts().garbled, 1U);
    EXPECT_EQ(Client(server->port()).write(1), 0) << "others are served";
}

TEST_F(PlcServerTest, OneAddressWritesAtATime) {
    PlcServerOptions options;
    options.watchdog = std::chrono::seconds(2);
    start(options);
    const Client plc(server->port()), other(server->port(), "127.0.0.2");
    EXPECT_EQ(plc.write(1), 0);
    EXPECT_EQ(other.write(2), 6);
    EXPECT_EQ(registers.value, 1);
    other.send({0, 7, 0, 0, 0, 6, 1, 3, 0, 0, 0, 1});
    EXPECT_EQ(other.receive(11).size(), 11U) << "reading is free";
    // The same PLC on a new connection, the old one still open somewhere: it is not kept out.
    EXPECT_EQ(Client(server->port()).write(3), 0);
    clock.advance(std::chrono::milliseconds(2001));
    EXPECT_EQ(other.write(4), 0) << "nobody has written for so long";
    EXPECT_EQ(plc.write(5), 6);
    EXPECT_EQ(counts().exceptions, 2U);
}

TEST_F(PlcServerTest, OnlyWhoWasNamedMayConnect) {
    PlcServerOptions options;
    ASSERT_TRUE(options.peers.add("127.0.0.9"));
    start(options);
    EXPECT_TRUE(Client(server->port()).closed());
    EXPECT_EQ(Client(server->port(), "127.0.0.9").write(1), 0);
    EXPECT_EQ(counts().refused, 1U);
}

TEST_F(PlcServerTest, ANewcomerDisplacesTheOneThatIsSilentForLongest) {
    start({});
    std::vector<std::unique_ptr<Client>> clients;
    for (std::uint8_t i = 0; i < 8; ++i) {
        clients.push_back(std::make_unique<Client>(server->port()));
        ASSERT_EQ(clients.back()->write(i), 0);
        clock.advance(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(clients[0]->write(9), 0);
    const Client ninth(server->port());
    EXPECT_EQ(ninth.write(10), 0);
    EXPECT_TRUE(clients[1]->closed());
    EXPECT_EQ(clients[0]->write(11), 0);
    EXPECT_EQ(counts().connections, 8U);
}

TEST_F(PlcServerTest, OtherMachinesOnlyByName) {
    PlcServerOptions options;
    options.address = "0.0.0.0";
    const auto open = PlcServer::start(context.get_executor(), options, registers, clock);
    ASSERT_FALSE(open);
    EXPECT_EQ(open.error().code, core::ErrorCode::usage);
    EXPECT_NE(open.error().message.find("--plc-allow"), std::string::npos);
    options.address = "nowhere";
    EXPECT_FALSE(PlcServer::start(context.get_executor(), options, registers, clock));
}

}  // namespace
}  // namespace cmm::cell
