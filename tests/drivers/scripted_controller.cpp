// SPDX-License-Identifier: Apache-2.0
#include "scripted_controller.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace cmm::drivers::test {
namespace {

bool receive_exactly(int fd, std::uint8_t* to, std::size_t count) {
    while (count > 0) {
        const auto n = ::recv(fd, to, count, 0);
        if (n <= 0) return false;
        to += n;
        count -= static_cast<std::size_t>(n);
    }
    return true;
}

bool more_has_come(int fd) {
    pollfd look{fd, POLLIN, 0};
    return ::poll(&look, 1, 0) > 0;
}

void throw_away_what_has_come(int fd) {
    std::array<std::uint8_t, 4096> buffer;
    while (::recv(fd, buffer.data(), buffer.size(), MSG_DONTWAIT) > 0) {
    }
}

/// The first sample that an exchange (FC 23) asks for.
std::size_t wanted_from(const Bytes& pdu) {
    constexpr std::size_t values = 10, from = values + 2 * 3;
    return word(pdu, from) * std::size_t{65536} + word(pdu, from + 2);
}

void send_bytes(int fd, const Bytes& bytes) {
    // A client that is gone shows up at the next receive.
    [[maybe_unused]] const auto sent = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

}  // namespace

ScriptedController::ScriptedController() {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof name;
    auto* address = static_cast<sockaddr*>(static_cast<void*>(&name));
    if (::bind(listener_, address, size) != 0 || ::listen(listener_, 8) != 0 || ::pipe(wake_) != 0) {
        throw std::runtime_error("the scripted controller cannot listen");
    }
    ::getsockname(listener_, address, &size);
    port_ = ntohs(name.sin_port);
    thread_ = std::thread([this] { serve(); });
}

ScriptedController::~ScriptedController() {
    quit_ = true;
    [[maybe_unused]] const auto n = ::write(wake_[1], "q", 1);
    thread_.join();
    if (listener_ >= 0) ::close(listener_);
    ::close(wake_[0]);
    ::close(wake_[1]);
}

void ScriptedController::on_request(std::function<Fault(const Request&)> rule) {
    const std::lock_guard lock(mutex_);
    rule_ = std::move(rule);
}

void ScriptedController::set_register(std::size_t address, std::uint16_t value, bool mend_crc) {
    const std::lock_guard lock(mutex_);
    machine_.set_register(address, value, mend_crc);
}
std::uint16_t ScriptedController::register_at(std::size_t address) {
    const std::lock_guard lock(mutex_);
    return machine_.register_at(address);
}
void ScriptedController::end_motion(std::uint16_t result, std::uint16_t state) {
    const std::lock_guard lock(mutex_);
    machine_.end_motion(result, state);
}
void ScriptedController::motions_take(int exchanges) {
    const std::lock_guard lock(mutex_);
    machine_.motions_take(exchanges);
}

void ScriptedController::restart() {
    const std::lock_guard lock(mutex_);
    machine_.restart();
    drop_connection_ = true;
    [[maybe_unused]] const auto n = ::write(wake_[1], "d", 1);
}

void ScriptedController::close_listener() {
    const std::lock_guard lock(mutex_);
    ::shutdown(listener_, SHUT_RDWR);
}

int ScriptedController::executed(int opcode) {
    const std::lock_guard lock(mutex_);
    return machine_.executed(opcode);
}
std::uint32_t ScriptedController::acknowledged() {
    const std::lock_guard lock(mutex_);
    return machine_.acknowledged();
}
std::uint32_t ScriptedController::newest() {
    const std::lock_guard lock(mutex_);
    return machine_.newest();
}
int ScriptedController::connections() {
    const std::lock_guard lock(mutex_);
    return connections_;
}
std::chrono::steady_clock::time_point ScriptedController::stop_arrived() {
    const std::lock_guard lock(mutex_);
    return machine_.stop_arrived();
}
std::uint16_t ScriptedController::stop_value() {
    const std::lock_guard lock(mutex_);
    return machine_.stop_value();
}

void ScriptedController::serve() {
    while (!quit_) {
        std::array<pollfd, 2> wait{{{listener_, POLLIN, 0}, {wake_[0], POLLIN, 0}}};
        ::poll(wait.data(), wait.size(), -1);
        if (wait[1].revents != 0) {
            char byte = 0;
            [[maybe_unused]] const auto n = ::read(wake_[0], &byte, 1);
            continue;
        }
        const int fd = ::accept(listener_, nullptr, nullptr);
        if (fd < 0) return;  // close_listener()
        const int on = 1;
        ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        {
            const std::lock_guard lock(mutex_);
            ++connections_;
            drop_connection_ = false;
            held_back_.clear();
            last_first_.clear();
        }
        while (serve_client(fd)) {
            if (!last_first_.empty() && !more_has_come(fd)) answer_held_back(fd);
        }
        ::close(fd);
    }
}

bool ScriptedController::serve_client(int fd) {
    std::array<pollfd, 2> wait{{{fd, POLLIN, 0}, {wake_[0], POLLIN, 0}}};
    ::poll(wait.data(), wait.size(), -1);
    if (wait[1].revents != 0) {
        char byte = 0;
        [[maybe_unused]] const auto n = ::read(wake_[0], &byte, 1);
        const std::lock_guard lock(mutex_);
        return !quit_ && !drop_connection_;
    }
    Bytes frame(6);
    if (!receive_exactly(fd, frame.data(), 6)) return false;
    const std::size_t following = word(frame, 4);
    frame.resize(6 + following);
    if (!receive_exactly(fd, frame.data() + 6, following)) return false;
    return answer(fd, frame);
}

bool ScriptedController::answer(int fd, const Bytes& frame) {
    const Bytes pdu(frame.begin() + 7, frame.end());
    std::function<Fault(const Request&)> rule;
    {
        const std::lock_guard lock(mutex_);
        rule = rule_;
    }
    const Request request{pdu[0], word(pdu, 1), ++requests_};
    const Fault fault = rule ? rule(request) : Fault::none;  // without the lock: it may ask for our state
    const std::lock_guard lock(mutex_);
    if (fault == Fault::silent) return true;
    if (fault == Fault::closed) return false;
    const bool refused = fault == Fault::busy || fault == Fault::illegal_value;
    const auto exception = static_cast<std::uint8_t>(fault == Fault::busy ? 6 : 3);
    const Bytes body = refused ? Bytes{static_cast<std::uint8_t>(pdu[0] | 0x80), exception} : machine_.execute(pdu);
    Bytes reply{frame[0], frame[1], 0, 0};
    add_word(reply, body.size() + 1);
    reply.push_back(frame[6]);
    reply.insert(reply.end(), body.begin(), body.end());
    const std::size_t from = pdu[0] == 23 ? wanted_from(pdu) : 0;
    // Of several requests under way a later one may have been answered: that block is none of before.
    if (fault != Fault::old_block || last_block_from_ <= from) spoil(fault, reply);
    if (pdu[0] == 23 && fault == Fault::none) {
        last_block_ = body;
        last_block_from_ = from;
    }
    if (pdu[0] == 3 && word(pdu, 1) == 64 && fault == Fault::none) keep_status(body);
    if (fault == Fault::lost_reply) return true;
    if (fault == Fault::late_reply) {
        held_back_ = reply;
        return true;
    }
    if (fault == Fault::last_first) {
        last_first_.push_back(reply);
        return true;
    }
    if (fault == Fault::alone) throw_away_what_has_come(fd);
    if (!held_back_.empty()) {
        send_bytes(fd, held_back_);
        held_back_.clear();
    }
    send_bytes(fd, reply);
    return fault != Fault::closed_mid;
}

void ScriptedController::answer_held_back(int fd) {
    for (; !last_first_.empty(); last_first_.pop_back())
        send_bytes(fd, last_first_.back());
}

void ScriptedController::keep_status(const Bytes& body) {
    constexpr std::size_t command_sequence = 2 + 2 * 4;  // behind function and length
    if (!status_.empty() && word(status_, command_sequence) != word(body, command_sequence)) status_before_ = status_;
    status_ = body;
}

void ScriptedController::spoil(Fault fault, Bytes& reply) {
    switch (fault) {
        case Fault::wrong_id:
            reply[1] = static_cast<std::uint8_t>(reply[1] + 100);
            break;
        case Fault::truncated:
        case Fault::closed_mid:
            reply.resize(reply.size() / 2 + 1);
            break;
        case Fault::bad_crc:
            reply[12] ^= 0x10;
            break;
        case Fault::garbage:
            reply.assign(12, 0xEE);
            break;
        case Fault::old_status:
            std::copy(status_before_.begin(), status_before_.end(), reply.begin() + 7);
            break;
        case Fault::old_block:
            if (!last_block_.empty()) std::copy(last_block_.begin(), last_block_.end(), reply.begin() + 7);
            break;
        default:
            break;
    }
}

}  // namespace cmm::drivers::test
