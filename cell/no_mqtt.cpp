// SPDX-License-Identifier: Apache-2.0
// In a build without libmosquitto.
#include "cell/mqtt_publisher.hpp"

namespace cmm::cell {

struct MqttPublisher::Impl {};

core::Result<std::unique_ptr<MqttPublisher>> MqttPublisher::start(const MqttOptions& options,
                                                                  std::function<void(const std::string&)> /*notice*/) {
    return core::fail(
        core::ErrorCode::usage,
        "mqtt://" + options.host + ": this build speaks no MQTT; build it where libmosquitto-dev is installed");
}

MqttPublisher::MqttPublisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MqttPublisher::~MqttPublisher() = default;
void MqttPublisher::publish(const std::string& /*topic*/, std::string /*payload*/, bool /*retained*/) {}
MqttCounts MqttPublisher::counts() const {
    return {};
}

}  // namespace cmm::cell
