// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fitting/chain_state.hpp"

namespace cmm::fitting {

/// Where the way turns far from point to point no polynomial goes through the ends of arcs and the few points between
/// them, and good ones pass for runs of bad ones. Those come back with which the way bends no other way and no more
/// sharply than it does around them, as it would at a bad point (docs/theory.md, section 2).
void free_coarse_runs(ChainState& chain);

}  // namespace cmm::fitting
