// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "fitting/chain_state.hpp"

namespace cmm::fitting {

/// Bad points side by side bear each other out: among all others each is predicted, and only the good points beside
/// them stand out, or are put out in their place. Where a good point from low to high still stands out, the shortest
/// run near it, of two to five, is bad that leaves nobody who does, with all beside it good again, and which the points
/// around contradict, all of it. True when there was one. O(high - low).
bool convict_excused_runs(ChainState& chain, std::ptrdiff_t low, std::ptrdiff_t high);

}  // namespace cmm::fitting
