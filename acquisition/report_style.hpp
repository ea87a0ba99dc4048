// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace cmm::acquisition {

/// The style sheet of report.html: light and dark by the reader's setting, paper always light.
std::string_view report_style();

}  // namespace cmm::acquisition
