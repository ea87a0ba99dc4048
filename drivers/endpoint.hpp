// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace cmm::drivers {

/// Where a machine is, as one URL:
///   modbus+tcp://host[:502][?unit=1]                 modbus+rtu:///dev/ttyUSB0[?baud=115200&parity=even&unit=1]
///   modbus+rtu+tcp://gateway[:502][?unit=1]          line+serial:///dev/ttyUSB0[?baud=115200&parity=none]
///   linuxcnc://host[:5007]
///   ipp://host[:1294]       replay:run.cmmrun        demo:
/// docs/cli.md lists the options.
/// A plain value; defaults are filled in. Schemes we have no form for are kept for the registry to judge.
struct Endpoint {
    std::string scheme;
    std::string host;  ///< network schemes; IPv6 without brackets
    std::uint16_t port = 0;
    std::string path;                            ///< device or file
    std::map<std::string, std::string> options;  ///< after '?', checked for the known schemes

    /// Errors: usage, with the URL and the place.
    static core::Result<Endpoint> parse(std::string_view url);
    /// The URL again, defaults written out.
    std::string text() const;
    /// A whole number among the options (already checked for known schemes).
    std::int64_t integer(const std::string& option, std::int64_t fallback) const;
    /// A word among the options.
    std::string word(const std::string& option, const std::string& fallback) const;
    /// "host:port", or the device or file.
    std::string place() const;
};

}  // namespace cmm::drivers
