// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

/// A client that shares nothing with the server: bytes to a socket and back.
namespace cmm::web::test {

class RawClient {
  public:
    explicit RawClient(std::uint16_t port);
    ~RawClient();
    RawClient(const RawClient&) = delete;
    RawClient& operator=(const RawClient&) = delete;

    bool send(const std::string& bytes) const;
    /// Up to the end of an HTTP answer with a Content-Length, or what came until the other side closed or the time was
    /// over.
    std::string answer(std::chrono::milliseconds patience = std::chrono::seconds(10));
    /// The payload of the next WebSocket text frame; empty: none came.
    std::string frame(std::chrono::milliseconds patience = std::chrono::seconds(10));
    /// Whether the other side closes within the time.
    bool closed(std::chrono::milliseconds patience);

  private:
    bool more(std::chrono::steady_clock::time_point until);
    int socket_ = -1;
    std::string seen_;
};

/// One request on a connection of its own; the status, or 0 without an answer.
struct Answer {
    int status = 0;
    std::string head, body;
};
Answer ask(std::uint16_t port, const std::string& request);
/// With Host, and whatever `fields` adds ("Name: value\r\n").
Answer get(std::uint16_t port, const std::string& target, const std::string& fields = "");
Answer post(std::uint16_t port, const std::string& target, const std::string& body, const std::string& fields = "");
std::string bearer(const std::string& token);
std::string upgrade_request(std::uint16_t port, const std::string& target, const std::string& fields = "");

}  // namespace cmm::web::test
