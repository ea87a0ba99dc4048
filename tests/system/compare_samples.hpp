// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace cmm::test {

using Counts = std::array<std::int32_t, 3>;

/// The samples of run files, in the order of their jobs, against the log of the simulator on which all of them were
/// scanned: each once and in order, numbered from 1 in each run; of a controller that was restarted, the first part of
/// what it had recorded until then. For jobs that are done. Empty: all is well.
std::string compare_samples(const std::vector<std::string>& run_files, const std::string& log_file);

/// The same for the counts of the run files and of the log, the latter from one start of the controller to the next.
std::string compare_counts(const std::vector<Counts>& recorded, const std::vector<std::vector<Counts>>& starts);

}  // namespace cmm::test
