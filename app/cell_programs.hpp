// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "acquisition/part_file.hpp"
#include "core/error.hpp"

namespace cmm::app {

/// Part files by the program number that their names begin with: 7.toml, 007-rotor.toml.
using CellPrograms = std::map<std::uint16_t, std::string>;
/// Errors: input_missing (no folder, or no such file in it), usage (a number twice).
core::Result<CellPrograms> find_programs(const std::string& folder);

/// The part file with this serial number in it, so that the run file and all that is made from it say which part it
/// was. Errors: those of load_part_to_measure; config_invalid where the number cannot be put in.
core::Result<acquisition::PartFile> part_with_serial(const std::string& file, const std::string& serial);

/// The highest number that a folder of a run in `folder` begins with; 0: none.
std::uint32_t last_run_in(const std::string& folder);
/// "000017-SN_4711": number and serial number as the name of a folder.
std::string run_folder_name(std::uint32_t run, const std::string& serial);

}  // namespace cmm::app
