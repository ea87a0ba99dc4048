// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/error.hpp"
#include "sim/spline.hpp"

/// Section files (docs/part-file.md, "Section files"): closed profiles in millimetres.
namespace cmm::sim {

/// All profiles of the files, turned so that the span is +z. `span`: "x", "y", "z" or "auto". A closing point that
/// repeats the first is left out, so are points with a flag other than 0. Errors: input_missing, input_invalid with
/// file:line:column.
core::Result<std::vector<Points>> read_sections(const std::vector<std::string>& files, const std::string& span);

/// One file's text; `name` is its file name (messages, and `_z<number>` for two columns).
core::Result<std::vector<Points>> parse_sections(std::string_view content, const std::string& name);

}  // namespace cmm::sim
