// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <optional>
#include <utility>

#include "acquisition/gauge_study.hpp"
#include "acquisition/journal.hpp"
#include "acquisition/run_results.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/study_design.hpp"
#include "core/text.hpp"

namespace cmm::app {
namespace {

core::Result<acquisition::StudyRun> judged(const StudyInput& input, const acquisition::PartFile* part) {
    const auto journal = acquisition::Journal::read(input.run_file);
    if (!journal) return tl::unexpected(journal.error());
    const auto& header = (*journal)->header();
    // The serial number is that of the part that was measured, whatever file judges it.
    const auto own = acquisition::parse_part_file(header.part_text, header.part_path);
    if (!own) return tl::unexpected(own.error());
    const auto result = acquisition::results_of_run(input.run_file, part);
    if (!result) return tl::unexpected(result.error());
    const std::string machine = header.machine_model + " " + header.machine_serial;
    return acquisition::study_run(*result, header.plan_hash, input.part.empty() ? own->serial : input.part,
                                  input.appraiser.empty() ? machine : input.appraiser);
}

core::Result<acquisition::GaugeStudy> study(const StudyOptions& options) {
    if (options.format.empty() != options.out.empty())
        return core::fail(core::ErrorCode::usage, "--format and --out go together");
    const auto inputs = study_inputs(options.inputs, options.design);
    if (!inputs) return tl::unexpected(inputs.error());
    std::optional<acquisition::PartFile> part;
    if (!options.part.empty()) {
        auto loaded = acquisition::load_part_file(options.part);
        if (!loaded) return tl::unexpected(loaded.error());
        part = std::move(*loaded);
    }
    std::vector<acquisition::StudyRun> runs;
    Progress progress(options.json);
    for (const auto& input : *inputs) {
        progress.show(static_cast<double>(runs.size()) / static_cast<double>(inputs->size()), input.run_file);
        auto run = judged(input, part ? &*part : nullptr);
        if (!run) return tl::unexpected(run.error());
        runs.push_back(std::move(*run));
    }
    return acquisition::make_gauge_study(std::move(runs));
}

std::string written(const acquisition::GaugeStudy& found, const std::string& format) {
    if (format == "csv") return acquisition::study_csv(found);
    return format == "html" ? acquisition::study_html(found) : acquisition::study_json(found);
}

}  // namespace

int run_study(const StudyOptions& options) {
    const auto found = study(options);
    if (!found) return report(found.error(), options.json);
    if (!options.out.empty()) {
        if (auto status = core::write_file(options.out, written(*found, options.format)); !status)
            return report(status.error(), options.json);
    }
    std::fputs((options.json ? acquisition::study_json(*found) : acquisition::study_text(*found)).c_str(), stdout);
    if (!options.out.empty()) std::fprintf(stderr, "written: %s\n", options.out.c_str());
    return 0;
}

}  // namespace cmm::app
