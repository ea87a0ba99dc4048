// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exports.hpp"
#include "acquisition/run_results.hpp"
#include "acquisition/traceability.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/run_input.hpp"
#include "app/scan_runner.hpp"

namespace cmm::app {

int run_gate(const GateOptions& options) {
    const std::string run_file = run_file_of(options.input);
    const auto gate = acquisition::load_gate_file(options.gate);
    if (!gate) return report(gate.error(), options.json);
    const auto journal = acquisition::Journal::read(run_file);
    if (!journal) return report(journal.error(), options.json);
    auto part = acquisition::parse_part_file((*journal)->header().part_text, (*journal)->header().part_path);
    if (!part) return report(part.error(), options.json);
    const std::size_t looks = part->gate.rule.looks;  // at these points; another file does not change that
    part->gate = *gate;
    part->gate.rule.looks = looks;
    auto result = acquisition::results_of_run(run_file, &*part);
    if (!result) return report(result.error(), options.json);
    result->sources.push_back(acquisition::source_file("Gate", options.gate));
    return print_result(*result, options.input, options.json);
}

}  // namespace cmm::app
