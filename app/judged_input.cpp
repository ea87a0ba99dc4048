// SPDX-License-Identifier: Apache-2.0
#include "app/judged_input.hpp"

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>

#include "acquisition/run_results.hpp"
#include "app/run_input.hpp"
#include "core/text.hpp"

namespace cmm::app {
namespace {

/// A folder, a run file by its name or by what an SQLite file begins with, or what is not there and looks like a
/// folder.
bool is_run(const std::string& input) {
    std::error_code ignored;
    if (input.ends_with(".cmmrun") || std::filesystem::is_directory(input, ignored)) return true;
    if (!std::filesystem::exists(input, ignored)) return std::filesystem::path(input).extension().empty();
    constexpr std::string_view begins = "SQLite format 3";
    std::array<char, begins.size()> head{};
    std::ifstream file(input, std::ios::binary);
    return file.read(head.data(), head.size()) && std::string_view(head.data(), head.size()) == begins;
}

core::Result<acquisition::PartResult> judge_run(const std::string& input, double stylus_radius_mm,
                                                const acquisition::PartFile* part, acquisition::OperatorChoice choice) {
    if (stylus_radius_mm >= 0.0)
        return core::fail(core::ErrorCode::usage,
                          "--stylus-radius does not go with a run file: the run knows its ball");
    const std::string run_file = run_file_of(input);
    std::error_code ignored;
    if (run_file != input && !std::filesystem::exists(run_file, ignored) &&
        std::filesystem::exists(input + "/result.json", ignored))
        return core::fail(core::ErrorCode::usage,
                          input +
                              " holds results of point files and no run: give the point files themselves, with "
                              "--stylus-radius MM or --part FILE as to fit");
    return acquisition::results_of_run(run_file, part, std::move(choice));
}

/// The command line goes before the part file, which may be meant for another stylus or a slip of either: that is said.
double ball_radius_mm(const JudgedInput& input, const acquisition::PartFile* part) {
    if (input.stylus_radius_mm < 0.0) return part->stylus.radius_mm;
    if (part != nullptr && part->stylus.radius_given && part->stylus.radius_mm != input.stylus_radius_mm)
        std::fprintf(stderr, "warning: the ball's radius is %s mm by --stylus-radius, not %s mm as in %s\n",
                     core::fixed(input.stylus_radius_mm, 4).c_str(), core::fixed(part->stylus.radius_mm, 4).c_str(),
                     part->path.c_str());
    return input.stylus_radius_mm;
}

}  // namespace

core::Result<acquisition::PartResult> judge_input(const JudgedInput& input) {
    auto choice = acquisition::OperatorChoice::parse(input.rejected, input.restored);
    if (!choice) return tl::unexpected(choice.error());
    std::optional<acquisition::PartFile> part;
    if (!input.part.empty()) {
        auto loaded = acquisition::load_part_file(input.part);
        if (!loaded) return tl::unexpected(loaded.error());
        part = std::move(*loaded);
    }
    const auto* judged_by = part ? &*part : nullptr;
    if (input.inputs.size() == 1 && is_run(input.inputs.front()))
        return judge_run(input.inputs.front(), input.stylus_radius_mm, judged_by, std::move(*choice));
    if (input.stylus_radius_mm < 0.0 && !part) {
        return core::fail(
            core::ErrorCode::usage,
            "the points' ball radius is not known: give --stylus-radius MM (0 if they lie on the part) or --part FILE");
    }
    const auto sections = acquisition::read_points(input.inputs);
    if (!sections) return tl::unexpected(sections.error());
    return acquisition::results_of_points(*sections, ball_radius_mm(input, judged_by), judged_by, std::move(*choice));
}

}  // namespace cmm::app
