// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace cmm::acquisition {

/// To a whole picometre (of a value in mm): far below any meaning; it keeps 0.1 + 0.2 out of files, and what was read
/// from a file is written into the next one as the same text.
inline double to_picometres(double value_mm) {
    return std::round(value_mm * 1e9) / 1e9;
}

}  // namespace cmm::acquisition
