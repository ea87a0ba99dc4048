// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "fitting/chain_state.hpp"

namespace cmm::fitting {

/// Runs of one to five points that lie off the curve through those around them, all by about as much: bad where this
/// explains the points better than any smooth curve does, or one whose curvature jumps (Bayesian information criterion,
/// Schwarz 1978; docs/theory.md, section 2). Refers to the chain, which must outlive it.
class LiftedRuns {
  public:
    explicit LiftedRuns(ChainState& chain);
    ~LiftedRuns();
    LiftedRuns(const LiftedRuns&) = delete;
    LiftedRuns& operator=(const LiftedRuns&) = delete;

    /// Makes them bad, the surest first. True when there was one. O(n). Again, when others have become bad or the
    /// scatter has become smaller: runs that can not have become bad by that are not looked at anew.
    bool convict();

  private:
    class Search;
    std::unique_ptr<Search> search_;
};

}  // namespace cmm::fitting
