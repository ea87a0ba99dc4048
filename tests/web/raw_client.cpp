// SPDX-License-Identifier: Apache-2.0
#include "tests/web/raw_client.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace cmm::web::test {

using Clock = std::chrono::steady_clock;

RawClient::RawClient(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_port = htons(port);
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0) {
        ::close(socket_);
        socket_ = -1;
    }
}

RawClient::~RawClient() {
    if (socket_ >= 0) ::close(socket_);
}

bool RawClient::send(const std::string& bytes) const {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
        const auto now = ::send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
        if (now <= 0) return false;
        sent += static_cast<std::size_t>(now);
    }
    return true;
}

bool RawClient::more(Clock::time_point until) {
    pollfd wait{socket_, POLLIN, 0};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    if (::poll(&wait, 1, static_cast<int>(std::max<std::int64_t>(0, left))) <= 0) return false;
    char buffer[65536];
    const auto got = ::recv(socket_, buffer, sizeof buffer, 0);
    if (got <= 0) return false;
    seen_.append(buffer, static_cast<std::size_t>(got));
    return true;
}

std::string RawClient::answer(std::chrono::milliseconds patience) {
    const auto until = Clock::now() + patience;
    constexpr const char* length = "Content-Length: ";
    while (true) {
        const auto head = seen_.find("\r\n\r\n");
        const auto field = seen_.find(length);
        std::size_t whole = std::string::npos;
        if (head != std::string::npos && field < head)
            whole = head + 4 + std::strtoul(seen_.c_str() + field + std::string(length).size(), nullptr, 10);
        if (head != std::string::npos && seen_.starts_with("HTTP/1.1 101")) whole = head + 4;
        if (seen_.size() >= whole || !more(until)) {
            const std::string all = seen_.substr(0, whole);
            seen_.erase(0, all.size());
            return all;
        }
    }
}

std::string RawClient::frame(std::chrono::milliseconds patience) {
    const auto until = Clock::now() + patience;
    const auto byte = [this](std::size_t i) {
        return static_cast<std::uint64_t>(static_cast<unsigned char>(seen_[i]));
    };
    while (true) {
        std::size_t head = 2;
        std::uint64_t size = 0;
        if (seen_.size() >= 2) {
            size = byte(1) & 127U;
            const std::size_t extra = size == 126 ? 2 : size == 127 ? 8 : 0;
            head += extra;
            if (extra > 0 && seen_.size() >= head) {
                size = 0;
                for (std::size_t i = 2; i < head; ++i)
                    size = (size << 8U) | byte(i);
            }
        }
        if (seen_.size() >= 2 && seen_.size() >= head + size) {
            const std::string payload = seen_.substr(head, size);
            const bool text = (byte(0) & 15U) == 1U;
            seen_.erase(0, head + size);
            if (text) return payload;
            continue;
        }
        if (!more(until)) return {};
    }
}

bool RawClient::closed(std::chrono::milliseconds patience) {
    const auto until = Clock::now() + patience;
    while (more(until)) {
    }
    return Clock::now() < until;
}

Answer ask(std::uint16_t port, const std::string& request) {
    RawClient client(port);
    client.send(request);
    const std::string text = client.answer();
    Answer answer;
    if (!text.starts_with("HTTP/1.1 ")) return answer;
    answer.status = std::atoi(text.c_str() + 9);
    const auto head = text.find("\r\n\r\n");
    answer.head = text.substr(0, head);
    answer.body = text.substr(std::min(text.size(), head + 4));
    return answer;
}

namespace {

std::string host(std::uint16_t port) {
    return "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
}

}  // namespace

Answer get(std::uint16_t port, const std::string& target, const std::string& fields) {
    return ask(port, "GET " + target + " HTTP/1.1\r\n" + host(port) + fields + "\r\n");
}

Answer post(std::uint16_t port, const std::string& target, const std::string& body, const std::string& fields) {
    return ask(port, "POST " + target + " HTTP/1.1\r\n" + host(port) +
                         "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n" +
                         fields + "\r\n" + body);
}

std::string bearer(const std::string& token) {
    return "Authorization: Bearer " + token + "\r\n";
}

std::string upgrade_request(std::uint16_t port, const std::string& target, const std::string& fields) {
    return "GET " + target + " HTTP/1.1\r\n" + host(port) +
           "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
           fields + "\r\n";
}

}  // namespace cmm::web::test
