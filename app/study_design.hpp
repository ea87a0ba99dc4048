// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace cmm::app {

/// A run of a study: its file, and who measured what where the user says so (empty: as the run says).
struct StudyInput {
    std::string run_file, part, appraiser;
};

/// `run,part,appraiser` with a header line, in any order; run names are relative to the file's folder. Errors:
/// input_missing, input_invalid.
core::Result<std::vector<StudyInput>> read_study_design(const std::string& file);

/// The inputs of the command line: those named there, then those of the design file. A run that stands in both has what
/// the design says. Errors: those of the design file.
core::Result<std::vector<StudyInput>> study_inputs(const std::vector<std::string>& named, const std::string& design);

}  // namespace cmm::app
