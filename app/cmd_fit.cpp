// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "acquisition/exports.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/scan_runner.hpp"

namespace cmm::app {

int run_fit(const FitOptions& options) {
    const auto result = judge_input(options.input);
    if (!result) return report(result.error(), options.json);
    std::error_code code;
    std::filesystem::create_directories(options.out, code);
    if (auto status = acquisition::write_outputs(*result, options.out); !status)
        return report(status.error(), options.json);
    return print_result(*result, options.out, options.json);
}

}  // namespace cmm::app
