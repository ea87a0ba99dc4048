// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "fitting/chain_state.hpp"

namespace cmm::fitting {

/// Looks for the bad points of a stretch of accused ones, where runs of up to five may excuse each other.
class StretchSearch {
  public:
    explicit StretchSearch(ChainState& chain) : chain_(chain) {}

    /// Settles the accused points from low to high: by letting the good ones come back and, when that leaves many out,
    /// by taking the worst away; the smaller set explains the stretch.
    void settle(std::ptrdiff_t low, std::ptrdiff_t high);

  private:
    void grow(std::ptrdiff_t low, std::ptrdiff_t high);
    void weed(std::ptrdiff_t low, std::ptrdiff_t high);
    void verify(std::ptrdiff_t low, std::ptrdiff_t high);
    void take_from_ends();
    bool take_from_middle();
    std::size_t longest_open() const;
    bool clear(const Verdict& verdict, std::ptrdiff_t i) const;
    Verdict judge_unresolved(std::ptrdiff_t i);
    double sampling_error(std::ptrdiff_t i);

    ChainState& chain_;
    std::vector<std::ptrdiff_t> open_;  // in order
    std::vector<Verdict> verdicts_;     // of the open points
};

}  // namespace cmm::fitting
