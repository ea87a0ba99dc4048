// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "acquisition/part_file.hpp"
#include "acquisition/section_result.hpp"
#include "app/commands.hpp"
#include "core/error.hpp"

namespace cmm::app {

struct RunnerOptions {
    std::string machine, part, out, events;
    bool resume = false, json = false;
    bool touch = false;               ///< measure by single touches
    bool stop_when_rejected = false;  ///< also where the part file does not ask for it
    double wait_s = -1.0;             ///< at rest, for what may pass; negative: as the part file says
    std::shared_ptr<const acquisition::PartFile> known_part;  ///< instead of the file `part`
    bool scratch = false;                                     ///< `out` does not outlive the command: it is not named
    PageSettings page;
    std::string title;  ///< first line on the terminal
};

/// The main job on any machine: connect, scan, judge, write the outputs; prints the verdict table. Returns the exit
/// code. SIGINT and SIGTERM stop the machine and leave a run that can be resumed; a second one does not wait for the
/// orderly end.
int run_main_job(const RunnerOptions& options);

/// Prints one finished result: the verdict table and the folder (empty: none), or with `json` the whole document.
/// Returns the verdict's exit code.
int print_result(const acquisition::PartResult& result, const std::string& out, bool json);

}  // namespace cmm::app
