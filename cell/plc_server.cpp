// SPDX-License-Identifier: Apache-2.0
#include "cell/plc_server.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <utility>
#include <vector>

namespace cmm::cell {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t most_connections = 8;
constexpr auto longest_silence = std::chrono::seconds(60);
constexpr auto look_every = std::chrono::seconds(1);
constexpr std::size_t requests_in_one_piece = 16;

const auto no_throw = asio::as_tuple(asio::use_awaitable);

struct Connection {
    Connection(tcp::socket the_socket, asio::ip::address the_peer, core::Duration now)
        : socket(std::move(the_socket)), peer(std::move(the_peer)), heard(now) {}
    void close() {
        error_code ignored;
        socket.close(ignored);
    }
    tcp::socket socket;
    asio::ip::address peer;
    core::Duration heard;
};

}  // namespace

struct PlcServer::Impl : std::enable_shared_from_this<PlcServer::Impl> {
    Impl(const asio::any_io_executor& executor, const PlcServerOptions& the_options, RegisterAccess& the_registers,
         const core::Clock& the_clock)
        : options(the_options), registers(the_registers), clock(the_clock), acceptor(executor), timer(executor) {}

    static asio::awaitable<void> accept(std::shared_ptr<Impl> self);
    static asio::awaitable<void> serve(std::shared_ptr<Impl> self, std::shared_ptr<Connection> connection);
    static asio::awaitable<void> sweep(std::shared_ptr<Impl> self);
    void admit(tcp::socket socket);
    void make_room();
    std::size_t answer(Connection& connection, std::span<const std::uint8_t> request,
                       std::span<std::uint8_t, longest_adu> reply);
    void close();

    PlcServerOptions options;
    RegisterAccess& registers;
    const core::Clock& clock;
    tcp::acceptor acceptor;
    asio::steady_timer timer;
    std::vector<std::shared_ptr<Connection>> connections;
    PlcServerCounts counts;
    asio::ip::address writer;  // wrote last
    core::Duration wrote{0};
    bool written = false;  // by anybody, ever
};

namespace {

/// The registers as one peer may use them.
class PeerAccess final : public RegisterAccess {
  public:
    using Write = std::function<ModbusException(std::size_t, std::span<const std::uint16_t>)>;
    PeerAccess(RegisterAccess& registers, Write write) : registers_(registers), write_(std::move(write)) {}
    ModbusException read(std::size_t address, std::span<std::uint16_t> to) override {
        return registers_.read(address, to);
    }
    ModbusException write(std::size_t address, std::span<const std::uint16_t> from) override {
        return write_(address, from);
    }

  private:
    RegisterAccess& registers_;
    Write write_;
};

}  // namespace

std::size_t PlcServer::Impl::answer(Connection& connection, std::span<const std::uint8_t> request,
                                    std::span<std::uint8_t, longest_adu> reply) {
    const auto now = clock.now();
    connection.heard = now;
    PeerAccess access(registers, [&](std::size_t address, std::span<const std::uint16_t> from) {
        if (written && connection.peer != writer && now - wrote <= options.watchdog) return ModbusException::busy;
        const auto outcome = registers.write(address, from);
        if (outcome == ModbusException::none) {
            written = true;
            writer = connection.peer;
            wrote = now;
        }
        return outcome;
    });
    const std::size_t size = answer_request(access, options.unit, request, reply);
    ++counts.requests;
    constexpr std::size_t function_at = 7;
    if ((reply[function_at] & 0x80U) != 0) ++counts.exceptions;
    return size;
}

asio::awaitable<void> PlcServer::Impl::accept(std::shared_ptr<Impl> self) {
    while (true) {
        auto [code, socket] = co_await self->acceptor.async_accept(no_throw);
        if (code == asio::error::operation_aborted || !self->acceptor.is_open()) co_return;
        if (!code) {
            self->admit(std::move(socket));
            continue;
        }
        // No descriptor left, for example: not at once again.
        asio::steady_timer pause(self->timer.get_executor(), look_every);
        co_await pause.async_wait(no_throw);
    }
}

void PlcServer::Impl::admit(tcp::socket socket) {
    error_code code;
    const auto peer = socket.remote_endpoint(code).address();
    if (code) return;
    const bool known = options.peers.empty() ? peer.is_loopback() : options.peers.contain(peer);
    if (!known) {
        ++counts.refused;
        return;
    }
    make_room();
    socket.set_option(tcp::no_delay(true), code);
    auto connection = std::make_shared<Connection>(std::move(socket), peer, clock.now());
    connections.push_back(connection);
    ++counts.accepted;
    asio::co_spawn(timer.get_executor(), serve(shared_from_this(), connection), asio::detached);
}

/// A PLC whose old connection nobody has closed is let in all the same.
void PlcServer::Impl::make_room() {
    if (connections.size() < most_connections) return;
    const auto oldest = std::min_element(connections.begin(), connections.end(),
                                         [](const auto& a, const auto& b) { return a->heard < b->heard; });
    (*oldest)->close();
    connections.erase(oldest);
}

asio::awaitable<void> PlcServer::Impl::serve(std::shared_ptr<Impl> self, std::shared_ptr<Connection> connection) {
    std::array<std::uint8_t, requests_in_one_piece * longest_adu> buffer{};
    std::array<std::uint8_t, longest_adu> reply{};
    std::size_t filled = 0;
    bool alive = true;
    while (alive) {
        auto [code, size] = co_await connection->socket.async_read_some(
            asio::buffer(buffer.data() + filled, buffer.size() - filled), no_throw);
        if (code) break;
        filled += size;
        std::size_t taken = 0;
        auto cut = cut_request(std::span(buffer).first(filled));
        while (alive && cut.kind == RequestCut::Kind::request) {
            const auto request = std::span<const std::uint8_t>(buffer).subspan(taken, cut.size);
            const std::size_t answered = self->answer(*connection, request, reply);
            auto [failed, sent] =
                co_await asio::async_write(connection->socket, asio::buffer(reply.data(), answered), no_throw);
            alive = !failed;
            taken += cut.size;
            cut = cut_request(std::span(buffer).subspan(taken, filled - taken));
        }
        if (cut.kind == RequestCut::Kind::garbled) {
            ++self->counts.garbled;
            break;
        }
        std::copy(buffer.begin() + static_cast<std::ptrdiff_t>(taken),
                  buffer.begin() + static_cast<std::ptrdiff_t>(filled), buffer.begin());
        filled -= taken;
    }
    connection->close();
    std::erase(self->connections, connection);
}

asio::awaitable<void> PlcServer::Impl::sweep(std::shared_ptr<Impl> self) {
    while (self->acceptor.is_open()) {
        const auto now = self->clock.now();
        for (const auto& connection : self->connections)
            if (now - connection->heard > longest_silence) connection->close();
        self->timer.expires_after(look_every);
        co_await self->timer.async_wait(no_throw);
    }
}

void PlcServer::Impl::close() {
    error_code ignored;
    acceptor.close(ignored);
    timer.cancel();
    for (const auto& connection : connections)
        connection->close();
}

PlcServer::PlcServer(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
PlcServer::~PlcServer() {
    impl_->close();
}

core::Result<std::unique_ptr<PlcServer>> PlcServer::start(asio::any_io_executor executor,
                                                          const PlcServerOptions& options, RegisterAccess& registers,
                                                          const core::Clock& clock) {
    auto impl = std::make_shared<Impl>(executor, options, registers, clock);
    error_code code;
    const auto address = asio::ip::make_address(options.address, code);
    const tcp::endpoint place(address, options.port);
    if (!code && !address.is_loopback() && options.peers.empty()) {
        return core::fail(core::ErrorCode::usage,
                          options.address +
                              ": other machines reach this address and Modbus has no password: name those that may "
                              "with --plc-allow ADDRESS");
    }
    if (!code) impl->acceptor.open(place.protocol(), code);
    if (!code) impl->acceptor.set_option(tcp::acceptor::reuse_address(true), code);
    if (!code) impl->acceptor.bind(place, code);
    if (!code) impl->acceptor.listen(asio::socket_base::max_listen_connections, code);
    if (code) {
        return core::fail(core::ErrorCode::usage, options.address + ":" + std::to_string(options.port) +
                                                      ": cannot listen there: " + code.message());
    }
    asio::co_spawn(executor, Impl::accept(impl), asio::detached);
    asio::co_spawn(executor, Impl::sweep(impl), asio::detached);
    return std::unique_ptr<PlcServer>(new PlcServer(std::move(impl)));
}

std::uint16_t PlcServer::port() const {
    error_code ignored;
    return impl_->acceptor.local_endpoint(ignored).port();
}

PlcServerCounts PlcServer::counts() const {
    auto counts = impl_->counts;
    counts.connections = impl_->connections.size();
    return counts;
}

}  // namespace cmm::cell
