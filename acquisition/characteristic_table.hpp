// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "acquisition/section_result.hpp"

namespace cmm::acquisition {

/// Of the report: every characteristic that the part file asked for, with method, value, U95, nominal, deviation,
/// limits and decision, section by section. Empty where nothing was asked for.
std::string characteristic_table(const PartResult& part);

}  // namespace cmm::acquisition
