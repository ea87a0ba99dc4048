// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace cmm::app {

/// The run file of `RUN|DIR`.
inline std::string run_file_of(const std::string& input) {
    std::error_code ignored;
    return std::filesystem::is_directory(input, ignored) ? input + "/run.cmmrun" : input;
}

}  // namespace cmm::app
