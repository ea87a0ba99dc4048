// SPDX-License-Identifier: Apache-2.0
#include "fitting/excused_runs.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr std::ptrdiff_t near_by = 2;  // strides from who stands out to the run
constexpr auto longest = static_cast<std::ptrdiff_t>(longest_bad_run);
constexpr std::ptrdiff_t fewest_around = 4 * longest;  // the run and as many to either side are different ones

/// Points from first to last.
struct Run {
    std::ptrdiff_t first = 0, last = -1;
    bool empty() const { return last < first; }
};

/// The states around a run while it is supposed to be all that is bad there.
class Supposition {
  public:
    Supposition(ChainState& chain, Run run) : chain_(chain), run_(run), freed_(run) {
        for (std::ptrdiff_t i = run.first; i <= run.last; ++i)
            suppose(i, PointState::accused);
        while (run.first - freed_.first < longest && is_bad(freed_.first - 1))
            suppose(--freed_.first, PointState::good);
        while (freed_.last - run.last < longest && is_bad(freed_.last + 1))
            suppose(++freed_.last, PointState::good);
    }
    Supposition(const Supposition&) = delete;
    Supposition& operator=(const Supposition&) = delete;
    ~Supposition() {
        for (std::ptrdiff_t i = freed_.first; i <= freed_.last; ++i)
            chain_.state(i) = before_[slot(i)];
    }

    bool nobody_stands_out(std::ptrdiff_t near, std::ptrdiff_t by) const {
        const std::ptrdiff_t low = std::min(freed_.first, near) - by, high = std::max(freed_.last, near) + by;
        for (std::ptrdiff_t i = low; i <= high; ++i)
            if (chain_.exists(i) && chain_.state(i) == PointState::good && chain_.stands_out(i)) return false;
        return true;
    }

    /// Of the run's points from what the others predict; no further looked for when not more than `most`.
    double least_ratio(double most) const {
        double least = HUGE_VAL;
        for (std::ptrdiff_t i = run_.first; i <= run_.last && least > most; ++i) {
            const Verdict verdict = chain_.judge(i);
            least = verdict.resolved && !verdict.corner ? std::min(least, std::abs(verdict.ratio())) : 0.0;
        }
        return least;
    }

    /// It stays so.
    void stand() {
        for (std::ptrdiff_t i = freed_.first; i <= freed_.last; ++i)
            chain_.note(i, chain_.state(i), chain_.judge(i));
        for (std::ptrdiff_t i = freed_.first; i <= freed_.last; ++i)
            before_[slot(i)] = i < run_.first || i > run_.last ? PointState::good : PointState::bad;
    }

  private:
    std::size_t slot(std::ptrdiff_t i) const { return static_cast<std::size_t>(i - run_.first + longest); }
    bool is_bad(std::ptrdiff_t i) const { return chain_.exists(i) && chain_.state(i) == PointState::bad; }
    void suppose(std::ptrdiff_t i, PointState state) {
        before_[slot(i)] = chain_.state(i);
        chain_.state(i) = state;
    }

    ChainState& chain_;
    Run run_, freed_;  // with the bad points beside it that come back
    std::array<PointState, 3 * longest> before_{};
};

/// Of one length the run that the others contradict most.
Run find_run(ChainState& chain, std::ptrdiff_t at, std::ptrdiff_t length) {
    const std::ptrdiff_t by = near_by * chain.stride(at);
    Run found;
    double most = ChainState::reject_factor;
    for (std::ptrdiff_t first = at - by - length + 1; first <= at + by; ++first) {
        const Run run{first, first + length - 1};
        if (!chain.exists(run.first) || !chain.exists(run.last)) continue;
        const Supposition supposition(chain, run);
        if (!supposition.nobody_stands_out(at, by)) continue;
        const double least = supposition.least_ratio(most);
        if (least <= most) continue;
        most = least;
        found = run;
    }
    return found;
}

bool convict_run_at(ChainState& chain, std::ptrdiff_t at) {
    for (std::ptrdiff_t length = 2; length <= longest; ++length) {
        const Run found = find_run(chain, at, length);
        if (found.empty()) continue;
        Supposition(chain, found).stand();
        const std::ptrdiff_t by = longest + 3 * chain.stride(at);
        chain.test(found.first - by, found.last + by);
        return true;
    }
    return false;
}

}  // namespace

bool convict_excused_runs(ChainState& chain, std::ptrdiff_t low, std::ptrdiff_t high) {
    if (chain.size() < fewest_around) return false;
    bool any = false;
    for (std::ptrdiff_t i = low; i <= high; ++i)
        if (chain.state(i) == PointState::good && chain.stands_out(i)) any = convict_run_at(chain, i) || any;
    return any;
}

}  // namespace cmm::fitting
