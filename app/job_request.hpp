// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "acquisition/operator_choice.hpp"
#include "acquisition/part_file.hpp"
#include "acquisition/scan_job.hpp"
#include "core/error.hpp"
#include "drivers/machine.hpp"
#include "drivers/machine_file.hpp"

namespace cmm::app {

std::uint64_t random_seed();
/// A run of this part that is made now, its run file in the folder `out`; the nominal is loaded. Errors: those of
/// load_nominal.
core::Result<acquisition::ScanRequest> new_request(acquisition::PartFile part, const std::string& out,
                                                   const drivers::LinkSettings& machine);
/// An operator has decided about points while the run went on: the outcome follows.
void judge_as_chosen(acquisition::ScanOutcome& outcome, const std::string& run_file,
                     acquisition::OperatorChoice choice);
/// The user does not want to wait for the orderly end: the machine is told to stop once more, then the process is gone.
/// The run file is made for being cut off at any instant.
[[noreturn]] void abort_run(drivers::Machine& machine, bool json);

}  // namespace cmm::app
