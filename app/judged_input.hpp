// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "acquisition/section_result.hpp"
#include "core/error.hpp"

namespace cmm::app {

/// What `fit` and `export` judge: a run (its file or its folder), or points from files.
struct JudgedInput {
    std::vector<std::string> inputs;
    double stylus_radius_mm = -1.0;               ///< of points from files; negative: that of the part file
    std::string part;                             ///< empty: the run's own; none for points
    std::vector<std::string> rejected, restored;  ///< an operator's word: sequence numbers and ranges
};

/// Errors: those of the files; usage (what does not go together, points whose ball is not known, a decision about a
/// point that is not there).
core::Result<acquisition::PartResult> judge_input(const JudgedInput& input);

}  // namespace cmm::app
