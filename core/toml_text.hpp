// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace cmm::core {

/// A place in a text, counted from 1; columns in bytes.
struct TextPlace {
    std::size_t line = 1, column = 1;
};

/// The first byte outside ASCII that is neither in a string nor in a comment of a TOML text: TOML 1.0 has no use for
/// one there (bare keys, numbers and marks are ASCII), and toml++ 3.3 and 3.4 end in undefined behaviour at some.
std::optional<TextPlace> first_foreign_letter(std::string_view toml) noexcept;

}  // namespace cmm::core
