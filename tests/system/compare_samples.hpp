// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace cmm::test {

/// The samples of run files, in the order of their jobs, against the log of the simulator on which all of them were
/// scanned: each once and in order, numbered from 1 in each run; of a controller that was restarted, the first part of
/// what it had recorded until then. For jobs that are done. Empty: all is well.
std::string compare_samples(const std::vector<std::string>& run_files, const std::string& log_file);

}  // namespace cmm::test
