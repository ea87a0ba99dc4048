// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fitting/chain_state.hpp"

namespace cmm::fitting {

/// Judges the last sparse points of each side anew: beside a densely measured edge, whose curvature begins between two
/// of them, the test and the predictions over the joint excuse bad points and accuse good ones. The side alone judges
/// them, from within to the edge, each that it bears out being heard for the next (docs/theory.md, section 2). O(n).
void judge_side_ends(ChainState& chain);

}  // namespace cmm::fitting
