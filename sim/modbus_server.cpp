// SPDX-License-Identifier: Apache-2.0
#include "sim/modbus_server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

namespace cmm::sim {
namespace {

constexpr std::size_t most_clients = 64;
constexpr std::size_t most_unsent = 1 << 16;  // a client that does not read its replies is not read either

/// A file descriptor with an owner.
class Descriptor {
  public:
    Descriptor() = default;
    explicit Descriptor(int fd) : fd_(fd) {}
    Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(fd_, other.fd_);
        return *this;
    }
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    int get() const { return fd_; }

  private:
    int fd_ = -1;
};

void make_nonblocking(int fd) {
    ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL, 0) | O_NONBLOCK);
}

bool would_block() {
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

}  // namespace

/// One connection: bytes in, bytes out. Closed when `alive` is false.
struct ModbusServer::Client {
    Descriptor socket;
    std::vector<std::uint8_t> in, out;
    bool alive = true;

    short wanted() const {
        return static_cast<short>((out.size() < most_unsent ? POLLIN : 0) | (out.empty() ? 0 : POLLOUT));
    }

    void serve(RegisterDevice& device) {
        send();
        if (out.size() < most_unsent) receive();
        // Afterwards either no complete request is left or replies are, so that the next wake-up goes on.
        while (alive && answer_some(device))
            send();
    }

  private:
    /// Answers complete requests as long as there is room for replies; false if it answered none.
    bool answer_some(RegisterDevice& device) {
        std::size_t used = 0;
        while (out.size() < most_unsent) {
            mbap::Frame frame;
            const auto parse = mbap::next_frame(std::span<const std::uint8_t>(in).subspan(used), frame);
            if (parse == mbap::Parse::malformed) alive = false;
            if (parse != mbap::Parse::complete) break;
            answer_frame(device, frame, out);
            used += frame.size;
        }
        in.erase(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(used));
        return used > 0;
    }

    void receive() {
        std::array<std::uint8_t, 16384> buffer;
        const ssize_t got = ::recv(socket.get(), buffer.data(), buffer.size(), 0);
        if (got > 0) in.insert(in.end(), buffer.begin(), buffer.begin() + got);
        if (got == 0 || (got < 0 && !would_block())) alive = false;
    }

    void send() {
        if (out.empty()) return;
        const ssize_t sent = ::send(socket.get(), out.data(), out.size(), MSG_NOSIGNAL);
        if (sent > 0) out.erase(out.begin(), out.begin() + sent);
        if (sent < 0 && !would_block()) alive = false;
    }
};

struct ModbusServer::Wires {
    Descriptor listener, wake_read, wake_write;
    std::vector<Client> clients;
    std::vector<pollfd> watched;
};

ModbusServer::ModbusServer() : wires_(std::make_unique<Wires>()) {}
ModbusServer::~ModbusServer() = default;

core::Result<std::unique_ptr<ModbusServer>> ModbusServer::listen(const std::string& address, std::uint16_t port) {
    const std::string where = address + ":" + std::to_string(port);
    const auto failed = [&](const char* what) {
        return core::fail(core::ErrorCode::transport_connect,
                          "cannot " + std::string(what) + " " + where + ": " + std::strerror(errno));
    };
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_port = htons(port);
    if (::inet_pton(AF_INET, address.c_str(), &name.sin_addr) != 1)
        return core::fail(core::ErrorCode::usage, "'" + address + "' is not an IPv4 address to listen on");
    std::unique_ptr<ModbusServer> server(new ModbusServer());
    Wires& wires = *server->wires_;
    wires.listener = Descriptor(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (wires.listener.get() < 0) return failed("open a socket for");
    const int on = 1;
    ::setsockopt(wires.listener.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    auto* generic = static_cast<sockaddr*>(static_cast<void*>(&name));
    if (::bind(wires.listener.get(), generic, sizeof name) != 0) return failed("bind");
    if (::listen(wires.listener.get(), 16) != 0) return failed("listen on");
    make_nonblocking(wires.listener.get());
    socklen_t size = sizeof name;
    ::getsockname(wires.listener.get(), generic, &size);
    server->port_ = ntohs(name.sin_port);
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC | O_NONBLOCK) != 0) return failed("make a wake-up pipe for");
    wires.wake_read = Descriptor(pipe[0]);
    wires.wake_write = Descriptor(pipe[1]);
    return server;
}

void ModbusServer::stop() noexcept {
    stopping_ = true;
    const char byte = 0;
    // A full pipe wakes the loop just as well.
    [[maybe_unused]] const ssize_t written = ::write(wires_->wake_write.get(), &byte, 1);
}

void ModbusServer::accept_clients() {
    for (;;) {
        Descriptor socket(::accept4(wires_->listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
        if (socket.get() < 0) return;
        if (wires_->clients.size() >= most_clients) continue;
        // Without it small pipelined replies wait for the client's delayed acknowledgement.
        const int on = 1;
        ::setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        wires_->clients.push_back(Client{std::move(socket), {}, {}, true});
    }
}

void ModbusServer::wait(int timeout_ms) {
    auto& watched = wires_->watched;
    watched.clear();
    watched.push_back({wires_->listener.get(), POLLIN, 0});
    watched.push_back({wires_->wake_read.get(), POLLIN, 0});
    for (const Client& client : wires_->clients)
        watched.push_back({client.socket.get(), client.wanted(), 0});
    if (::poll(watched.data(), watched.size(), timeout_ms) < 0)
        for (pollfd& entry : watched)
            entry.revents = 0;
}

void ModbusServer::run(RegisterDevice& device, const Tick& tick) {
    int timeout_ms = tick();
    while (!stopping_) {
        wait(timeout_ms);
        auto& clients = wires_->clients;
        for (std::size_t i = 0; i < clients.size(); ++i)
            if (wires_->watched[i + 2].revents != 0) clients[i].serve(device);
        std::erase_if(clients, [](const Client& client) { return !client.alive; });
        if (wires_->watched[0].revents != 0) accept_clients();
        timeout_ms = tick();
    }
}

}  // namespace cmm::sim
