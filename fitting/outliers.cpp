// SPDX-License-Identifier: Apache-2.0
#include "fitting/outliers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/chain_state.hpp"
#include "fitting/coarse_runs.hpp"
#include "fitting/excused_runs.hpp"
#include "fitting/lifted_runs.hpp"
#include "fitting/side_ends.hpp"
#include "fitting/stretch_search.hpp"
#include "fitting/swapped_runs.hpp"

namespace cmm::fitting {
namespace {

constexpr double witness_sd = 2.0;       // in sigmas: of a prediction that frees a point at the first hearing
constexpr std::ptrdiff_t reach = 2;      // neighbours a side in the test: so far a suspect may accuse
constexpr std::ptrdiff_t merge_gap = 3;  // accused stretches nearer than this are one
constexpr std::size_t fewest_judged_points = 7;
constexpr int most_accusations = 3;

class Finder {
  public:
    Finder(std::span<const Vec2> points, bool closed, double floor) : chain_(points, closed, floor), search_(chain_) {}

    BadPoints run() {
        test_all();
        LiftedRuns lifted(chain_);
        if (lifted.convict()) chain_.estimate_scatter();
        // What is found makes the scatter smaller, and more stands out.
        for (int round = 0; round < most_accusations && accuse(); ++round) {
            for (const auto& [low, high] : stretches_) {
                const bool clear = convict(low, high);
                if (!clear) hear(low, high);
                const bool excused = convict_excused_runs(chain_, low, high);
                if (!clear || excused) acquit(low, high);
            }
            for (const auto& [low, high] : stretches_)
                chain_.test(low - reach, high + reach);
            chain_.estimate_scatter();
        }
        // Runs beside those that show far more were not looked at.
        if (chain_.any_bad() && lifted.convict()) chain_.estimate_scatter();
        exchange_swapped_runs(chain_);
        judge_side_ends(chain_);
        // What the scan is too coarse to tell.
        free_coarse_runs(chain_);
        return chain_.report();
    }

    std::vector<char> run_while_clear() {
        test_all();
        accuse();
        for (const auto& [low, high] : stretches_)
            convict(low, high);
        return chain_.report().bad;
    }

  private:
    using Stretch = std::pair<std::ptrdiff_t, std::ptrdiff_t>;  // first and last point

    void test_all() {
        chain_.test(0, chain_.size() - 1);
        chain_.estimate_scatter();
        if (chain_.set_strides()) chain_.estimate_scatter();
    }

    /// Every suspect accuses the neighbours that its test rests on, and itself. False when there is none.
    bool accuse() {
        const bool closed = chain_.closed();
        const std::ptrdiff_t n = chain_.size();
        stretches_.clear();
        for (std::ptrdiff_t i = 0; i < n; ++i) {
            if (!chain_.suspicious(i)) continue;
            const std::ptrdiff_t by = reach * chain_.stride(i);
            hold(stretches_, i - by, i + by);
        }
        if (closed && stretches_.size() > 1 && stretches_.front().first + n <= stretches_.back().second + merge_gap) {
            stretches_.front().first = std::min(stretches_.front().first, stretches_.back().first - n);
            stretches_.pop_back();
        }
        for (auto& [low, high] : stretches_) {
            if (closed) {
                high = std::min(high, low + n - 1);
            } else {
                low = std::max<std::ptrdiff_t>(low, 0);
                high = std::min(high, n - 1);
            }
            for (std::ptrdiff_t i = low; i <= high; ++i)
                if (chain_.state(i) == PointState::good) chain_.state(i) = PointState::accused;
        }
        return !stretches_.empty();
    }

    /// Worst first (A9), as long as both sides together clear or convict the worst sharply. False when they do not.
    bool convict(std::ptrdiff_t low, std::ptrdiff_t high) {
        for (std::ptrdiff_t i = low; i <= high; ++i)
            if (chain_.state(i) == PointState::accused) chain_.state(i) = PointState::good;
        while (true) {
            std::ptrdiff_t worst = ChainState::none;
            double ratio = 0.0;
            for (std::ptrdiff_t i = low; i <= high; ++i) {
                const double now = chain_.ratio(i);
                if (now <= ratio || !chain_.suspicious(i)) continue;
                worst = i;
                ratio = now;
            }
            if (worst == ChainState::none) break;
            const Verdict verdict = chain_.judge(worst);
            if (!verdict.sharp) break;
            chain_.settled(worst);
            if (std::abs(verdict.ratio()) <= ChainState::reject_factor) continue;
            chain_.note(worst, PointState::bad, verdict);
            const std::ptrdiff_t by = 3 * chain_.stride(worst);
            chain_.test(worst - by, worst + by);
        }
        for (std::ptrdiff_t i = low; i <= high; ++i)
            if (chain_.suspicious(i)) return false;
        for (std::ptrdiff_t i = low; i <= high; ++i)
            chain_.settled(i);
        return true;
    }

    /// Who was convicted while others that are bad were still heard comes back when the good ones bear it out.
    void acquit(std::ptrdiff_t low, std::ptrdiff_t high) {
        for (std::ptrdiff_t i = low; i <= high; ++i) {
            if (chain_.state(i) != PointState::bad) continue;
            const Verdict verdict = chain_.judge(i);
            if (!verdict.sharp || std::abs(verdict.ratio()) > ChainState::reject_factor) continue;
            chain_.note(i, PointState::good, verdict);
            const std::ptrdiff_t by = 3 * chain_.stride(i);
            chain_.test(i - by, i + by);
        }
    }

    /// Judges every accused point of a stretch among all others: the clearly bad ones go first, the worst before all.
    /// What then agrees and is not next to what does not is free.
    void hear(std::ptrdiff_t low, std::ptrdiff_t high) {
        verdicts_.assign(static_cast<std::size_t>(high - low + 1), {});
        const auto verdict = [&](std::ptrdiff_t i) -> Verdict& { return verdicts_[static_cast<std::size_t>(i - low)]; };
        std::ptrdiff_t from = low, to = high;
        for (std::ptrdiff_t removed = 0; 2 * removed <= high - low; ++removed) {
            for (std::ptrdiff_t i = from; i <= to; ++i) {
                if (chain_.state(i) != PointState::good) continue;
                verdict(i) = chain_.judge(i);
                chain_.note(i, PointState::good, verdict(i));
            }
            std::ptrdiff_t worst = ChainState::none;
            for (std::ptrdiff_t i = low; i <= high; ++i)
                if (chain_.state(i) == PointState::good && verdict(i).sharp &&
                    std::abs(verdict(i).ratio()) > ChainState::reject_factor &&
                    (worst == ChainState::none || std::abs(verdict(i).ratio()) > std::abs(verdict(worst).ratio())))
                    worst = i;
            if (worst == ChainState::none) break;
            chain_.note(worst, PointState::bad, verdict(worst));
            const std::ptrdiff_t by = static_cast<std::ptrdiff_t>(Neighbours::most) * chain_.stride(worst);
            from = std::max(low, worst - by);
            to = std::min(high, worst + by);
        }
        std::vector<Stretch> held;
        for (std::ptrdiff_t i = low; i <= high; ++i) {
            // A wide prediction is no witness for a point far off it.
            const double wide = std::min(verdict(i).sd_mm, witness_sd * chain_.sigma_at(i));
            const bool agrees =
                verdict(i).resolved && std::abs(verdict(i).residual_mm) <= ChainState::reject_factor * wide;
            if (chain_.state(i) == PointState::bad || agrees) continue;
            const std::ptrdiff_t by = reach * chain_.stride(i);
            hold(held, std::max(low, i - by), std::min(high, i + by));
        }
        for (const auto& [first, last] : held)
            for (std::ptrdiff_t i = first; i <= last; ++i)
                if (chain_.state(i) == PointState::good) chain_.state(i) = PointState::accused;
        for (const auto& [first, last] : held)
            search_.settle(first, last);
        for (std::ptrdiff_t i = low; i <= high; ++i)
            chain_.settled(i);
    }

    static void hold(std::vector<Stretch>& stretches, std::ptrdiff_t low, std::ptrdiff_t high) {
        if (!stretches.empty() && low <= stretches.back().second + merge_gap) {
            stretches.back().second = high;
        } else {
            stretches.emplace_back(low, high);
        }
    }

    ChainState chain_;
    StretchSearch search_;
    std::vector<Stretch> stretches_;
    std::vector<Verdict> verdicts_;
};

}  // namespace

BadPoints find_bad_points(std::span<const Vec2> points, bool closed, double floor_mm) {
    if (points.size() >= fewest_judged_points) return Finder(points, closed, floor_mm).run();
    BadPoints all;
    all.bad.assign(points.size(), 0);
    all.corner.assign(points.size(), 0);
    all.residual.assign(points.size(), 0.0);
    all.threshold_mm.assign(points.size(), floor_mm);
    return all;
}

std::vector<char> find_clearly_bad_points(std::span<const Vec2> points, bool closed, double floor_mm) {
    if (points.size() < fewest_judged_points) return std::vector<char>(points.size(), 0);
    return Finder(points, closed, floor_mm).run_while_clear();
}

}  // namespace cmm::fitting
