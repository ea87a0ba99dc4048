// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>

#include "cell/mqtt_publisher.hpp"

namespace cmm::cell {

core::Result<MqttOptions> MqttOptions::parse(const std::string& url) {
    constexpr std::string_view scheme = "mqtt://";
    const auto wrong = [&](const std::string& why) {
        return core::fail(core::ErrorCode::usage, url + ": " + why + "; the form is mqtt://HOST[:1883][/PREFIX]");
    };
    if (!url.starts_with(scheme)) return wrong("is no broker's address");
    const std::string rest = url.substr(scheme.size());
    const auto slash = rest.find('/');
    std::string place = rest.substr(0, slash);
    MqttOptions options;
    options.prefix = slash == std::string::npos ? "cmmlive" : rest.substr(slash + 1);
    const auto bracket = place.rfind(']');
    const auto colon = place.rfind(':');
    if (colon != std::string::npos && (bracket == std::string::npos || colon > bracket)) {
        const char* const end = place.data() + place.size();
        const auto read = std::from_chars(place.data() + colon + 1, end, options.port);
        if (read.ec != std::errc() || read.ptr != end || options.port == 0) return wrong("the port makes no sense");
        place.resize(colon);
    }
    if (place.starts_with('[') && place.ends_with(']')) place = place.substr(1, place.size() - 2);
    options.host = place;
    if (place.empty() || place.find_first_of("@?#") != std::string::npos) return wrong("the host makes no sense");
    const auto& prefix = options.prefix;
    const bool bad = std::any_of(prefix.begin(), prefix.end(), [](char letter) {
        return letter <= ' ' || letter > '~' || letter == '+' || letter == '#';
    });
    constexpr std::size_t longest_prefix = 128;
    if (bad || prefix.empty() || prefix.front() == '/' || prefix.front() == '$' || prefix.back() == '/' ||
        prefix.size() > longest_prefix)
        return wrong("the prefix cannot begin topics");
    return options;
}

}  // namespace cmm::cell
