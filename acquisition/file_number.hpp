// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace cmm::acquisition {

/// A number as files keep it: nine decimals (of a value in mm: a picometre), far below any meaning. It keeps 0.1 + 0.2
/// out of files, and what was read from a file is written into the next one as the same text.
inline double file_number(double value) {
    return std::round(value * 1e9) / 1e9;
}

}  // namespace cmm::acquisition
