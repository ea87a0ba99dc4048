// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "acquisition/section_result.hpp"
#include "core/error.hpp"

namespace cmm::acquisition {

/// What an operator has decided about single points, by sequence number: rejected ones stay out of the fit, restored
/// ones stay in, whatever their neighbours or the controller say. A value.
class OperatorChoice {
  public:
    /// Lists as "12", "15-18" or "12,15-18". Errors: usage (no number, a range that runs backwards, more than a million
    /// points, a point both rejected and restored).
    static core::Result<OperatorChoice> parse(const std::vector<std::string>& rejected,
                                              const std::vector<std::string>& restored);
    /// A later word about a point takes the place of an earlier one; `withdraw`: nothing is said about it.
    void reject(std::uint64_t sequence);
    void restore(std::uint64_t sequence);
    void withdraw(std::uint64_t sequence);
    const std::set<std::uint64_t>& rejected() const { return rejected_; }
    const std::set<std::uint64_t>& restored() const { return restored_; }
    bool empty() const { return rejected_.empty() && restored_.empty(); }

    /// Writes the decisions into the points' verdicts and takes note of what was found.
    void apply(std::vector<RecordedPoint>& points);
    /// Errors: usage when a decision concerns a point that never came.
    core::Status all_found() const;

  private:
    std::set<std::uint64_t> rejected_, restored_, found_;
};

}  // namespace cmm::acquisition
