// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/error.hpp"

/// The secret that whoever moves or changes something must show.
namespace cmm::web {

/// 128 random bits as 32 hex digits. Errors: internal (the system has no randomness).
core::Result<std::string> new_token();
/// The one line of a file: 16 to 128 letters, digits, '-' and '_'. Errors: input_missing, config_invalid (another form,
/// or a file that others than its owner may read).
core::Result<std::string> read_token_file(const std::string& file);
/// In a time that does not tell how much of it was right.
bool same_token(std::string_view known, std::string_view shown) noexcept;

}  // namespace cmm::web
