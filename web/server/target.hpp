// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cmm::web {

/// A request's target, taken apart and decoded: "/api/run/a%20b?from=3" is {api, run, "a b"} and {from: 3}.
struct Target {
    std::vector<std::string> path;
    std::map<std::string, std::string> query;

    /// A whole number of the query; nothing when it is absent or no number.
    std::optional<std::uint64_t> number(const std::string& name) const;
};

/// Nothing for a target that no page of ours asks for: not from the root, longer than 1024 bytes, bad escapes, control
/// characters, empty segments, "." and "..", slashes or backslashes inside a segment, a parameter twice.
std::optional<Target> parse_target(std::string_view text);

}  // namespace cmm::web
