// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/error.hpp"

namespace cmm::cell {

struct MqttOptions {
    std::string host;
    std::uint16_t port = 1883;
    std::string prefix;          ///< of all topics, without a slash at its end
    std::string user, password;  ///< empty: none

    /// Of mqtt://HOST[:1883][/PREFIX]; the prefix is "cmmlive" where there is none. Errors: usage.
    static core::Result<MqttOptions> parse(const std::string& url);
};

struct MqttCounts {
    bool connected = false;
    std::uint64_t published = 0;  ///< the broker has them
    std::uint64_t dropped = 0;    ///< the queue was full
    std::uint64_t waiting = 0;
};

/// Says things to an MQTT broker (3.1.1, libmosquitto, QoS 1) and hears nothing. Nobody waits for it: messages stand in
/// a queue of 256 until the broker is there; of a retained topic only the newest; when it is full the oldest message
/// that is not retained goes, and is counted. `PREFIX/online` is "1" while the connection stands, otherwise "0" (will).
class MqttPublisher {
  public:
    /// Begins to connect, and goes on trying. `notice`: a line for people, from a thread of this object. Errors: usage
    /// (a build without libmosquitto), internal.
    static core::Result<std::unique_ptr<MqttPublisher>> start(const MqttOptions& options,
                                                              std::function<void(const std::string&)> notice);
    /// Gives what waits half a second where a broker is there.
    ~MqttPublisher();
    MqttPublisher(const MqttPublisher&) = delete;
    MqttPublisher& operator=(const MqttPublisher&) = delete;

    /// Under the prefix. Any thread; never waits for the network.
    void publish(const std::string& topic, std::string payload, bool retained);
    MqttCounts counts() const;

  private:
    struct Impl;
    explicit MqttPublisher(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace cmm::cell
