// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "acquisition/scan_job.hpp"
#include "core/error.hpp"

/// What the measurements of whole jobs share: the demo's blade, measured more densely.
namespace cmm::bench {

struct DenseBlade {
    const char* name;
    int sections;
    double pitch_mm, edge_density;
};

/// Writes the blade's part file into the folder, which must exist; returns its name.
std::string part_file(const std::string& config_folder, const std::filesystem::path& folder, const DenseBlade& blade);

/// A job on such a part. Errors: those of the part file and of its nominal.
core::Result<acquisition::ScanRequest> scan_request(const std::string& part_file, const std::string& run_file);

}  // namespace cmm::bench
