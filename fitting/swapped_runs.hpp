// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fitting/chain_state.hpp"

namespace cmm::fitting {

/// A run of two or three bad points that lie alike can put its good neighbours out in its place: the cubics over them
/// go astray alike. Where one to three good points stand between two bad ones on the same side, and the bad ones lie on
/// what the points beyond and each other foretell while those between do not, they change places. O(bad points).
void exchange_swapped_runs(ChainState& chain);

}  // namespace cmm::fitting
