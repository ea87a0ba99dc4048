// SPDX-License-Identifier: Apache-2.0
#include "fitting/excused_runs.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace cmm::fitting {
namespace {

constexpr std::ptrdiff_t near_by = 2;  // strides from who stands out to the run

class RunSearch {
  public:
    /// `at` stands out.
    RunSearch(ChainState& chain, std::ptrdiff_t at) : chain_(chain), at_(at), by_(chain.stride(at)) {
        const std::ptrdiff_t reach = near_by * by_ + static_cast<std::ptrdiff_t>(longest_bad_run);
        for (std::ptrdiff_t i = at - reach; i <= at + reach; ++i)
            if (chain.exists(i) && chain.state(i) == PointState::good) good_.push_back(i);
    }

    bool run() {
        for (std::size_t length = 2; length <= longest_bad_run; ++length) {
            std::span<const std::ptrdiff_t> found;
            double most = ChainState::reject_factor;
            for (std::size_t first = 0; first + length <= good_.size(); ++first) {
                const auto tried = std::span(good_).subspan(first, length);
                if (!is_near(tried)) continue;
                set(tried, PointState::accused);
                if (nobody_stands_out(tried)) {
                    const double least = least_ratio(tried, most);
                    if (least > most) {
                        most = least;
                        found = tried;
                    }
                }
                set(tried, PointState::good);
            }
            if (found.empty()) continue;
            convict(found);
            return true;
        }
        return false;
    }

  private:
    using Run = std::span<const std::ptrdiff_t>;

    /// Between the run's points may be bad ones that are known.
    bool is_near(Run run) const {
        return run.front() <= at_ + near_by * by_ && run.back() >= at_ - near_by * by_ &&
               run.back() - run.front() < static_cast<std::ptrdiff_t>(longest_bad_run);
    }

    void set(Run run, PointState state) {
        for (const std::ptrdiff_t i : run)
            chain_.state(i) = state;
    }

    bool nobody_stands_out(Run run) {
        const std::ptrdiff_t low = std::min(run.front(), at_) - near_by * by_,
                             high = std::max(run.back(), at_) + near_by * by_;
        for (std::ptrdiff_t i = low; i <= high; ++i)
            if (chain_.exists(i) && chain_.state(i) == PointState::good && chain_.stands_out(i)) return false;
        return true;
    }

    /// Of the run's points from what the others predict; not looked for further when it is not more than `most`.
    double least_ratio(Run run, double most) {
        double least = HUGE_VAL;
        for (std::size_t k = 0; k < run.size() && least > most; ++k) {
            const Verdict verdict = chain_.judge(run[k]);
            least = verdict.resolved && !verdict.corner ? std::min(least, std::abs(verdict.ratio())) : 0.0;
        }
        return least;
    }

    void convict(Run run) {
        set(run, PointState::accused);
        for (const std::ptrdiff_t i : run)
            chain_.note(i, PointState::accused, chain_.judge(i));
        set(run, PointState::bad);
        chain_.test(run.front() - 3 * by_, run.back() + 3 * by_);
    }

    ChainState& chain_;
    std::ptrdiff_t at_, by_;
    std::vector<std::ptrdiff_t> good_;  // near `at`, in order
};

}  // namespace

bool convict_excused_runs(ChainState& chain, std::ptrdiff_t low, std::ptrdiff_t high) {
    bool any = false;
    for (std::ptrdiff_t i = low; i <= high; ++i)
        if (chain.state(i) == PointState::good && chain.stands_out(i)) any = RunSearch(chain, i).run() || any;
    return any;
}

}  // namespace cmm::fitting
