// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fitting/chain_state.hpp"

namespace cmm::fitting {

/// Runs of one to five points that lie off the curve through those around them, all by about as much: bad where this
/// explains the points better than any smooth curve does, or one whose curvature jumps (Bayesian information criterion,
/// Schwarz 1978; docs/theory.md, section 2). The surest first. True when there was one. O(n).
bool convict_lifted_runs(ChainState& chain);

}  // namespace cmm::fitting
