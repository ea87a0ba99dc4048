// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cmm::acquisition {

/// Whether a file name holds a wildcard (`*`, `?` or `[`).
bool is_file_pattern(std::string_view name) noexcept;
/// The regular files that a pattern matches (wildcards in any part of the path), in natural order. Empty: nothing
/// matches.
std::vector<std::string> expand_file_pattern(const std::string& pattern);
/// Orders runs of digits by their value: section-2 before section-10.
bool natural_less(std::string_view a, std::string_view b) noexcept;

}  // namespace cmm::acquisition
