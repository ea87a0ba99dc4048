// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <optional>
#include <utility>

#include "acquisition/exports.hpp"
#include "acquisition/run_results.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/scan_runner.hpp"

namespace cmm::app {
namespace {

core::Result<acquisition::PartResult> fit(const FitOptions& options) {
    auto choice = acquisition::OperatorChoice::parse(options.rejected, options.restored);
    if (!choice) return tl::unexpected(choice.error());
    std::optional<acquisition::PartFile> part;
    if (!options.part.empty()) {
        auto loaded = acquisition::load_part_file(options.part);
        if (!loaded) return tl::unexpected(loaded.error());
        part = std::move(*loaded);
    }
    const auto* judged_by = part ? &*part : nullptr;
    if (options.inputs.size() == 1 && options.inputs.front().ends_with(".cmmrun")) {
        if (options.stylus_radius_mm >= 0.0) {
            return core::fail(core::ErrorCode::usage,
                              "--stylus-radius does not go with a run file: the run knows its ball");
        }
        return acquisition::results_of_run(options.inputs.front(), judged_by, std::move(*choice));
    }
    if (options.stylus_radius_mm < 0.0 && !part) {
        return core::fail(
            core::ErrorCode::usage,
            "the points' ball radius is not known: give --stylus-radius MM (0 if they lie on the part) or --part FILE");
    }
    const auto sections = acquisition::read_points(options.inputs);
    if (!sections) return tl::unexpected(sections.error());
    const double radius_mm = options.stylus_radius_mm >= 0.0 ? options.stylus_radius_mm : part->stylus.radius_mm;
    return acquisition::results_of_points(*sections, radius_mm, judged_by, std::move(*choice));
}

}  // namespace

int run_fit(const FitOptions& options) {
    const auto result = fit(options);
    if (!result) return report(result.error(), options.json);
    std::error_code code;
    std::filesystem::create_directories(options.out, code);
    if (auto status = acquisition::write_outputs(*result, options.out); !status)
        return report(status.error(), options.json);
    return print_result(*result, options.out, options.json);
}

}  // namespace cmm::app
