// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <list>
#include <string>
#include <thread>
#include <vector>

namespace cmm::test {

/// A network between TCP clients and a server on this host that takes its time: each byte arrives `one_way` after it
/// was sent, in either direction, however many are under way. A thread of its own.
class DistantNetwork {
  public:
    using Clock = std::chrono::steady_clock;

    /// Throws std::runtime_error when there is no port left.
    DistantNetwork(std::uint16_t server_port, Clock::duration one_way);
    ~DistantNetwork();
    DistantNetwork(const DistantNetwork&) = delete;
    DistantNetwork& operator=(const DistantNetwork&) = delete;

    /// Where clients connect to, on 127.0.0.1.
    std::uint16_t port() const { return port_; }
    /// The same as a url, with options like "unit=1&in_flight=8".
    std::string modbus_url(const std::string& options = "unit=1") const;

  private:
    struct Parcel {
        Clock::time_point due;
        std::vector<std::uint8_t> bytes;  // none: the sender has closed
    };
    struct Direction {
        int from = -1, to = -1;
        bool ended = false;
        std::deque<Parcel> under_way;
    };
    struct Connection {
        Direction there, back;
        bool alive = true;
    };

    void serve();
    void accept_client();
    void take(Direction& direction) const;
    static bool deliver(Direction& direction);
    void close_dead();

    std::uint16_t server_port_, port_ = 0;
    Clock::duration one_way_;
    int listener_;
    std::list<Connection> connections_;
    std::atomic<bool> quit_{false};
    std::thread thread_;
};

}  // namespace cmm::test
