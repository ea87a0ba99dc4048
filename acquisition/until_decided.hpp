// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace cmm::acquisition {

/// Bounds of what may be measured again of an undecided section.
struct UntilDecided {
    std::size_t passes = 2;      ///< at most; the risk of a decision is divided over them and the lap
    double seconds = 60.0;       ///< of all passes over a section, as planned
    double most_density = 16.0;  ///< times the points of the lap
};

}  // namespace cmm::acquisition
