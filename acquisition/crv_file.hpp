// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "acquisition/points_file.hpp"
#include "core/error.hpp"

namespace cmm::acquisition {

/// TurboGrid .crv/.curve: `# name Profile k` starts a profile, then one point x y z a line, white space between. A file
/// without profile lines is one curve. Points are kept as they are: the last may repeat the first.
/// Errors: input_invalid.
core::Result<std::vector<PointSection>> read_crv(std::string_view content, const std::string& name);

}  // namespace cmm::acquisition
