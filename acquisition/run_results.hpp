// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "acquisition/journal.hpp"
#include "acquisition/nominal.hpp"
#include "acquisition/operator_choice.hpp"
#include "acquisition/part_file.hpp"
#include "acquisition/points_file.hpp"
#include "acquisition/section_result.hpp"

namespace cmm::acquisition {

/// The part file that a run was measured with, as it is kept in the run file. Errors: those of Journal::read and of the
/// part file, with the run file's name.
core::Result<PartFile> part_of_run(const std::string& run_file);

/// A finished or broken run judged again from its raw points, by the part file it was measured with (`part` empty) or
/// by another one. The same functions as during the scan: the same contour to the last bit, unless an operator has
/// decided about points. Errors also: usage (a decision about a point that is not there).
core::Result<PartResult> results_of_run(const std::string& run_file, const PartFile* part, OperatorChoice choice = {});

/// Points from files, judged the same way; without numbers of their own they are numbered
/// from 1 in the order of the files. `ball_radius_mm` of the
/// points; a part file brings nominal and limits.
core::Result<PartResult> results_of_points(const std::vector<PointSection>& sections, double ball_radius_mm,
                                           const PartFile* part, OperatorChoice choice = {});

}  // namespace cmm::acquisition
