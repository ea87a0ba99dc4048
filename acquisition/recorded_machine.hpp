// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "acquisition/journal.hpp"
#include "core/error.hpp"
#include "drivers/machine.hpp"

/// What a machine could do, as the run file keeps it: names and numbers, so that a plan made for the recording is the
/// plan made for the machine.
namespace cmm::acquisition {

/// Kept beside them: whether the sections are measured by single touches (1) or scanned (0). Absent in older runs.
inline constexpr const char* touches_key = "measured_by_touches";

/// Kept beside them too: by how much the machine and its probe may err. Nothing of a run that was recorded without.
void add_errors(const drivers::MachineErrors& errors, std::map<std::string, double>& numbers);
drivers::MachineErrors recorded_errors(const Journal::Header& header);

/// Model, serial and count size have columns of their own and are left out.
std::map<std::string, double> capability_numbers(const drivers::Capabilities& machine);

/// The machine of a recorded run, answering that run's plan only. Errors: input_invalid (a number is missing: the run
/// was recorded by a version that did not keep them).
core::Result<drivers::Capabilities> recorded_capabilities(const Journal::Header& header);

}  // namespace cmm::acquisition
