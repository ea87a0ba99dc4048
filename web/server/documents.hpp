// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "acquisition/run_review.hpp"
#include "core/error.hpp"

/// What the page draws, as JSON (docs/page.md). Millimetres, part frame; coordinates to 0.1 um, deviations to 0.01 um.
namespace cmm::web {

/// Part, ball, limits, and every section's height and nominal.
core::Result<std::string> plan_document(const std::string& id, acquisition::RunReview& review);
/// The points behind sequence `after`, at most 20 000: where the ball's centre was, and against the nominal the
/// provisional deviation with the direction it lies in.
core::Result<std::string> points_document(acquisition::RunReview& review, std::uint64_t after);
/// One section as it is judged now: contour with deviations and uncertainty, every point with what became of it,
/// characteristics. Errors: input_missing (not recorded).
core::Result<std::string> section_document(acquisition::RunReview& review, std::size_t index);
/// The whole result with the operator's choice.
core::Result<std::string> result_document(const std::string& id, acquisition::RunReview& review);
/// One line of the list of runs, from result.json where there is one of this run, otherwise from the run file.
std::string summary_document(const std::string& id, const std::string& folder);
/// What an operator had decided when result.json was written; empty where there is none of this run.
acquisition::OperatorChoice recorded_choice(const std::string& folder, const std::string& run_id);

}  // namespace cmm::web
