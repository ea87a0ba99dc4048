// SPDX-License-Identifier: Apache-2.0
#include "app/study_design.hpp"

#include <algorithm>
#include <array>
#include <filesystem>

#include "acquisition/delimited_file.hpp"
#include "app/run_input.hpp"
#include "core/text.hpp"

namespace cmm::app {
namespace {

bool same_file(const std::string& a, const std::string& b) {
    std::error_code ignored;
    return a == b || std::filesystem::equivalent(a, b, ignored);
}

}  // namespace

core::Result<std::vector<StudyInput>> read_study_design(const std::string& file) {
    const auto content = core::read_file(file);
    if (!content) return tl::unexpected(content.error());
    const auto table = acquisition::read_delimited(*content, file);
    if (!table) return tl::unexpected(table.error());
    std::array<std::size_t, 3> columns{};
    for (std::size_t i = 0; i < columns.size(); ++i) {
        constexpr std::array names{"run", "part", "appraiser"};
        const auto found = std::find(table->header.begin(), table->header.end(), names[i]);
        if (found == table->header.end())
            return core::fail(core::ErrorCode::input_invalid,
                              file + ": no column \"" + names[i] + "\" (run, part and appraiser are wanted)");
        columns[i] = static_cast<std::size_t>(found - table->header.begin());
    }
    const auto folder = std::filesystem::path(file).parent_path();
    std::vector<StudyInput> inputs;
    for (const auto& row : table->rows) {
        const auto cell = [&](std::size_t i) { return std::string(row.cells[columns[i]].text); };
        inputs.push_back({run_file_of((folder / cell(0)).string()), cell(1), cell(2)});
    }
    return inputs;
}

core::Result<std::vector<StudyInput>> study_inputs(const std::vector<std::string>& named, const std::string& design) {
    std::vector<StudyInput> designed;
    if (!design.empty()) {
        auto read = read_study_design(design);
        if (!read) return tl::unexpected(read.error());
        designed = std::move(*read);
    }
    std::vector<StudyInput> inputs;
    for (const auto& name : named) {
        const std::string run_file = run_file_of(name);
        const bool known = std::any_of(designed.begin(), designed.end(),
                                       [&](const StudyInput& input) { return same_file(input.run_file, run_file); });
        if (!known) inputs.push_back({run_file, {}, {}});
    }
    inputs.insert(inputs.end(), designed.begin(), designed.end());
    return inputs;
}

}  // namespace cmm::app
