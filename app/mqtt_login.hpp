// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "cell/mqtt_publisher.hpp"
#include "core/error.hpp"

namespace cmm::app {

/// A broker's address, and who we are there: user and password on the two lines of a file (empty: nobody) that only its
/// owner may read. Errors: usage, input_missing, config_invalid.
core::Result<cell::MqttOptions> mqtt_options(const std::string& url, const std::string& login_file);

}  // namespace cmm::app
