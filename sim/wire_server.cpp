// SPDX-License-Identifier: Apache-2.0
#include "sim/wire_server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

namespace cmm::sim {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t most_clients = 64;
constexpr std::size_t most_unsent = 1 << 16;  // a client that does not read its replies is not read either
constexpr auto reopen_every = std::chrono::milliseconds(200);

bool would_block() {
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

core::Error failure(const std::string& what, const std::string& where) {
    return core::Error{core::ErrorCode::transport_connect,
                       "cannot " + what + " " + where + ": " + std::strerror(errno),
                       {},
                       core::Motion::not_concerned};
}

}  // namespace

/// Bytes in, bytes out over one descriptor. Done when `alive` is false.
struct WireServer::Connection {
    std::unique_ptr<WireProtocol> protocol;
    std::vector<std::uint8_t> in{}, out{};
    SteadyClock::time_point last_byte{};
    bool alive = true;
    core::Duration away{0};

    short wanted() const {
        return static_cast<short>((out.size() < most_unsent ? POLLIN : 0) | (out.empty() ? 0 : POLLOUT));
    }

    void serve(int fd) {
        send(fd);
        if (out.size() < most_unsent) receive(fd);
        // Afterwards either no complete request is left or replies are, so that the next wake-up goes on.
        while (alive && answer_some())
            send(fd);
    }
    /// Also without news: what does not become a request is dropped after a silence, and a reply may be due late.
    void idle(int fd) {
        while (alive && !in.empty() && answer_some())
            send(fd);
        if (alive) follow(protocol->idle(out));
        send(fd);
    }

  private:
    /// Answers complete requests as long as there is room for replies; false if it answered none.
    bool answer_some() {
        const core::Duration silent_for = SteadyClock::now() - last_byte;
        std::size_t used = 0;
        while (out.size() < most_unsent && used < in.size()) {
            const auto progress = protocol->answer(std::span<const std::uint8_t>(in).subspan(used), silent_for, out);
            follow(progress);
            if (progress.used == 0) break;
            used += progress.used;
        }
        in.erase(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(used));
        return used > 0;
    }

    void follow(const WireProtocol::Progress& progress) {
        alive = alive && progress.alive;
        away = progress.away;
    }

    void receive(int fd) {
        std::array<std::uint8_t, 16384> buffer;
        const ssize_t got = ::read(fd, buffer.data(), buffer.size());
        if (got > 0) {
            std::vector<std::uint8_t> fresh(buffer.begin(), buffer.begin() + got);
            protocol->arrived(fresh);
            in.insert(in.end(), fresh.begin(), fresh.end());
            last_byte = SteadyClock::now();
        }
        if (got == 0 || (got < 0 && !would_block())) alive = false;
    }

    void send(int fd) {
        if (out.empty()) return;
        ssize_t sent = ::send(fd, out.data(), out.size(), MSG_NOSIGNAL);
        if (sent < 0 && errno == ENOTSOCK) sent = ::write(fd, out.data(), out.size());
        if (sent > 0) out.erase(out.begin(), out.begin() + sent);
        if (sent < 0 && !would_block()) alive = false;
    }
};

struct WireServer::Listener {
    Descriptor socket;
    Speak speak;
};

/// A serial line: there for good, whether or not the device is.
struct WireServer::Port {
    SerialLine settings;
    Speak speak;
    std::optional<OpenLine> line;
    Connection connection;
    SteadyClock::time_point next_try{};
};

struct WireServer::Wires {
    struct Client {
        Descriptor socket;
        Connection connection;
    };
    Descriptor wake_read, wake_write;
    std::vector<Listener> listeners;
    std::vector<Port> ports;
    std::vector<Client> clients;
    std::vector<pollfd> watched;  // the wake-up pipe, listeners, ports, clients
};

WireServer::WireServer() : wires_(std::make_unique<Wires>()) {}
WireServer::~WireServer() = default;

core::Result<std::unique_ptr<WireServer>> WireServer::make() {
    std::unique_ptr<WireServer> server(new WireServer());
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC | O_NONBLOCK) != 0) return tl::unexpected(failure("make", "a wake-up pipe"));
    server->wires_->wake_read = Descriptor(pipe[0]);
    server->wires_->wake_write = Descriptor(pipe[1]);
    return server;
}

core::Result<std::uint16_t> WireServer::listen(const std::string& address, std::uint16_t port, Speak speak) {
    const std::string where = address + ":" + std::to_string(port);
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_port = htons(port);
    if (::inet_pton(AF_INET, address.c_str(), &name.sin_addr) != 1)
        return core::fail(core::ErrorCode::usage, "'" + address + "' is not an IPv4 address to listen on");
    Descriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (socket.get() < 0) return tl::unexpected(failure("open a socket for", where));
    const int on = 1;
    ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    auto* generic = static_cast<sockaddr*>(static_cast<void*>(&name));
    if (::bind(socket.get(), generic, sizeof name) != 0) return tl::unexpected(failure("bind", where));
    if (::listen(socket.get(), 16) != 0) return tl::unexpected(failure("listen on", where));
    socklen_t size = sizeof name;
    ::getsockname(socket.get(), generic, &size);
    wires_->listeners.push_back(Listener{std::move(socket), std::move(speak)});
    return ntohs(name.sin_port);
}

core::Status WireServer::open(const SerialLine& line, Speak speak) {
    auto opened = OpenLine::open(line);
    if (!opened) return tl::unexpected(opened.error());
    Connection connection{speak()};
    wires_->ports.push_back(Port{line, std::move(speak), std::move(*opened), std::move(connection)});
    return {};
}

void WireServer::reopen(Port& port) {
    const auto now = SteadyClock::now();
    if (now < port.next_try) return;
    port.next_try = now + reopen_every;
    auto opened = OpenLine::open(port.settings);
    if (!opened) return;
    port.line = std::move(*opened);
    port.connection = Connection{port.speak()};
}

void WireServer::stop() noexcept {
    stopping_ = true;
    const char byte = 0;
    // A full pipe wakes the loop just as well.
    [[maybe_unused]] const ssize_t written = ::write(wires_->wake_write.get(), &byte, 1);
}

void WireServer::accept_clients(Listener& listener) {
    for (;;) {
        Descriptor socket(::accept4(listener.socket.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
        if (socket.get() < 0) return;
        if (wires_->clients.size() >= most_clients) continue;
        // Without it small pipelined replies wait for the client's delayed acknowledgement.
        const int on = 1;
        ::setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        wires_->clients.push_back(Wires::Client{std::move(socket), Connection{listener.speak()}});
    }
}

void WireServer::wait(int timeout_ms) {
    auto& watched = wires_->watched;
    watched.clear();
    watched.push_back({wires_->wake_read.get(), POLLIN, 0});
    for (const Listener& listener : wires_->listeners)
        watched.push_back({listener.socket.get(), POLLIN, 0});
    for (const Port& port : wires_->ports)  // poll() passes over a negative descriptor
        watched.push_back({port.line ? port.line->fd() : -1, port.connection.wanted(), 0});
    for (const auto& client : wires_->clients)
        watched.push_back({client.socket.get(), client.connection.wanted(), 0});
    if (::poll(watched.data(), watched.size(), timeout_ms) < 0)
        for (pollfd& entry : watched)
            entry.revents = 0;
}

void WireServer::run(const Tick& tick) {
    int timeout_ms = tick();
    while (!stopping_) {
        wait(timeout_ms);
        const pollfd* entry = wires_->watched.data() + 1;
        std::vector<Listener*> callers;
        for (Listener& listener : wires_->listeners)
            if ((entry++)->revents != 0) callers.push_back(&listener);
        for (Port& port : wires_->ports) {
            const bool ready = (entry++)->revents != 0;
            if (port.line && ready) port.connection.serve(port.line->fd());
            if (port.line) port.connection.idle(port.line->fd());
            if (!port.connection.alive && port.line) {
                port.line.reset();
                port.next_try = SteadyClock::now() + port.connection.away;
            }
            if (!port.line) reopen(port);
        }
        for (auto& client : wires_->clients) {
            if ((entry++)->revents != 0) client.connection.serve(client.socket.get());
            client.connection.idle(client.socket.get());
        }
        std::erase_if(wires_->clients, [](const auto& client) { return !client.connection.alive; });
        for (Listener* listener : callers)
            accept_clients(*listener);
        timeout_ms = tick();
    }
}

}  // namespace cmm::sim
