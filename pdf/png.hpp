// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/error.hpp"

namespace cmm::pdf {

/// A picture (SVG with width and height or a viewBox) as PNG on white, `width_px` wide, its proportions kept: the bytes
/// of the file. The same picture gives the same bytes. Errors: config_invalid (this build writes no PNG, no font is
/// installed), internal (no SVG, Cairo).
core::Result<std::string> png_of(std::string_view svg, int width_px);

}  // namespace cmm::pdf
