// SPDX-License-Identifier: Apache-2.0
#include "fitting/side_ends.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr std::ptrdiff_t judged = 7;  // last points of a side
constexpr std::ptrdiff_t fewest_witnesses = 8;
constexpr std::size_t most_witnesses = 16;
constexpr std::ptrdiff_t farthest_witness = 32;     // points away
constexpr std::ptrdiff_t fewest_chain_points = 64;  // of a chain that has sides and edges
constexpr double least_step_ratio = 2.5;            // of a side's steps to an edge's
constexpr double last_step_share = 0.35;            // of a side's step: the one to its last point
constexpr std::ptrdiff_t near_edge = 3;             // points of the edge, of which the first good one is looked at
constexpr std::ptrdiff_t deep = 6, deepest = 96;    // points of the edge, to where the way has turned
constexpr double least_turn_rad = 0.2;
constexpr double agreeing = 3.0;    // standard deviations of a prediction
constexpr double condemning = 4.0;  // of a doubtful point, where the side goes on without it
constexpr double freeing_sd = 2.0;  // in sigmas: of a prediction that frees a point

/// How far it is from each point to the next.
class Steps {
  public:
    explicit Steps(const ChainState& chain) : chain_(chain) {
        for (std::ptrdiff_t i = 0; i < chain.size(); ++i)
            step_.push_back(chain.exists(i + 1) ? (chain.point(i + 1) - chain.point(i)).norm() : 0.0);
    }

    /// Whether the points are sparse up to there and dense from there on.
    bool side_ends_at(std::ptrdiff_t last, std::ptrdiff_t way) const {
        if (!chain_.exists(last - way * (judged + fewest_witnesses)) || !chain_.exists(last + way * 2 * deep))
            return false;
        const auto at = [&](std::ptrdiff_t k) { return step(last, way, k); };
        // Among three of five is one that is as large as the median, and one as small.
        if (std::max({at(-1), at(-2), at(-3)}) <= least_step_ratio * std::min({at(1), at(2), at(3)})) return false;
        const double of_edge = median({at(1), at(2), at(3), at(4), at(5)}), sparse = of_side(last, way);
        return sparse > least_step_ratio * of_edge && at(-1) > last_step_share * sparse;
    }
    double of_side(std::ptrdiff_t last, std::ptrdiff_t way) const {
        const auto at = [&](std::ptrdiff_t k) { return step(last, way, k); };
        return median({at(-1), at(-2), at(-3), at(-4), at(-5)});
    }

  private:
    /// From the k-th point behind `last` to the next.
    double step(std::ptrdiff_t last, std::ptrdiff_t way, std::ptrdiff_t k) const {
        const std::ptrdiff_t n = chain_.size(), from = way > 0 ? last + k : last - k - 1;
        return step_[static_cast<std::size_t>(from < 0 ? from + n : from < n ? from : from - n)];
    }
    static double median(std::array<double, 5> values) { return nth_smallest(values, 2); }

    const ChainState& chain_;
    std::vector<double> step_;
};

/// One end of one side: its points counted from the last sparse one, 0, on into the edge.
class SideEnd {
  public:
    SideEnd(ChainState& chain, std::ptrdiff_t last, std::ptrdiff_t way, double side_step_mm)
        : chain_(chain), last_(last), way_(way), side_step_(side_step_mm) {}

    void judge() {
        if (!look_outward()) return;
        Hearing hearing = hear(true);
        if (hearing.any_doubtful) {
            const Hearing other = hear(false);
            if (other.unexplained() < hearing.unexplained()) {
                hearing = other;
                hearing.condemn_doubtful();
            }
        }
        if (longest_run(hearing) > static_cast<std::ptrdiff_t>(longest_bad_run)) return;
        for (std::ptrdiff_t k = 1 - judged; k <= hearing.told; ++k) {
            const Word& word = hearing.of(k);
            if (word.state == chain_.state(at(k))) continue;
            Verdict verdict = word.verdict;
            verdict.residual_mm *= static_cast<double>(way_);
            chain_.note(at(k), word.state, verdict);
        }
    }

  private:
    /// What the side says of a point.
    struct Word {
        PointState state = PointState::good;
        bool doubtful = false;
        Verdict verdict;
    };
    struct Hearing {
        std::array<Word, judged> words{};
        std::ptrdiff_t told = -judged;  ///< the last that the side tells anything of
        bool doubtful_heard = true, any_doubtful = false;

        Word& of(std::ptrdiff_t k) { return words[static_cast<std::size_t>(k + judged - 1)]; }
        const Word& of(std::ptrdiff_t k) const { return words[static_cast<std::size_t>(k + judged - 1)]; }
        /// Without them the side bore out a later point.
        void condemn_doubtful() {
            bool goes_on = false;
            for (std::ptrdiff_t k = told; k > -judged; --k) {
                Word& word = of(k);
                if (word.doubtful && goes_on && std::abs(word.verdict.ratio()) > condemning)
                    word.state = PointState::bad;
                else
                    goes_on = goes_on || (!word.doubtful && word.state == PointState::good);
            }
        }
        std::ptrdiff_t unexplained() const {
            std::ptrdiff_t count = -told;
            for (std::ptrdiff_t k = 1 - judged; k <= told; ++k)
                count += of(k).doubtful || of(k).state == PointState::bad ? 1 : 0;
            return count;
        }
    };

    std::ptrdiff_t at(std::ptrdiff_t k) const { return last_ + way_ * k; }
    double sigma_mm(std::ptrdiff_t k) const { return chain_.largest_sigma(at(k), judged); }

    /// The way turns inwards at an edge. False where it hardly turns: there is none.
    bool look_outward() {
        const Vec2 along = chain_.point(last_) - chain_.point(at(-judged));
        for (std::ptrdiff_t far = 2 * deep; far <= deepest && far < chain_.size() / 4; far *= 2) {
            std::ptrdiff_t k = far;
            while (k < far + deep && chain_.exists(at(k)) && chain_.state(at(k)) != PointState::good)
                ++k;
            if (!chain_.exists(at(k))) return false;
            const double turn = turn_angle(along, chain_.point(at(k)) - chain_.point(last_));
            outward_ = turn > 0.0 ? 1.0 : -1.0;
            if (std::abs(turn) > least_turn_rad) return true;
        }
        return false;
    }

    /// From within to the edge.
    Hearing hear(bool doubtful_heard) const {
        Hearing hearing;
        hearing.doubtful_heard = doubtful_heard;
        for (std::ptrdiff_t k = 1 - judged; k <= 0; ++k) {
            Word word{chain_.state(at(k)), false, said_of(k, k, hearing)};
            if (!word.verdict.resolved) break;
            const double off = std::abs(word.verdict.ratio());
            if (off > ChainState::reject_factor) {
                if (word.state == PointState::good && !is_no_part(k, word.verdict, hearing)) break;
                word.state = PointState::bad;
            } else if (off >= agreeing) {
                word.doubtful = hearing.any_doubtful = true;
            } else if (std::abs(word.verdict.residual_mm) < agreeing * freeing_sd * sigma_mm(k)) {
                word.state = PointState::good;
            }
            hearing.of(k) = word;
            hearing.told = k;
        }
        return hearing;
    }

    /// Of point k by the good ones of the side before point `before`.
    Verdict said_of(std::ptrdiff_t k, std::ptrdiff_t before, const Hearing& hearing) const {
        const auto is_heard = [&](std::ptrdiff_t i) {
            if (i <= -judged) return chain_.state(at(i)) == PointState::good;
            return hearing.of(i).state == PointState::good && (hearing.doubtful_heard || !hearing.of(i).doubtful);
        };
        std::array<Vec2, most_witnesses> side;
        std::size_t count = 0;
        for (std::ptrdiff_t i = before - 1; i > before - farthest_witness && count < side.size(); --i)
            if (chain_.exists(at(i)) && is_heard(i)) side[count++] = chain_.point(at(i));
        return judge_beyond(std::span(side).first(count), chain_.point(at(k)), sigma_mm(k));
    }

    /// Off the side outwards lies no edge, and one that has begun to turn inwards by there goes on doing so: by twice
    /// that in as long a way.
    bool is_no_part(std::ptrdiff_t k, const Verdict& verdict, const Hearing& hearing) const {
        if (verdict.residual_mm * outward_ > 0.0) return true;
        std::ptrdiff_t beyond = 1;
        while (beyond <= near_edge && chain_.state(at(beyond)) != PointState::good)
            ++beyond;
        if (beyond > near_edge) return false;
        const Verdict of_edge = said_of(beyond, k, hearing);
        if (!of_edge.resolved) return false;
        const double way = (chain_.point(at(beyond)) - chain_.point(at(k))).norm();
        const double off = std::abs(verdict.residual_mm) * (1.0 + way / side_step_);
        return -of_edge.residual_mm * outward_ + agreeing * of_edge.sd_mm < off;
    }

    /// Of bad points, when the side is believed.
    std::ptrdiff_t longest_run(const Hearing& hearing) const {
        std::ptrdiff_t longest = 0, run = 0;
        for (std::ptrdiff_t k = 1 - judged; k <= near_edge; ++k) {
            const PointState state = k <= hearing.told ? hearing.of(k).state : chain_.state(at(k));
            run = state == PointState::bad ? run + 1 : 0;
            longest = std::max(longest, run);
        }
        return longest;
    }

    ChainState& chain_;
    std::ptrdiff_t last_, way_;
    double side_step_, outward_ = 1.0;
};

}  // namespace

void judge_side_ends(ChainState& chain) {
    if (chain.size() < fewest_chain_points) return;
    const Steps steps(chain);
    for (const std::ptrdiff_t way : {1, -1})
        for (std::ptrdiff_t i = 0; i < chain.size(); ++i)
            if (steps.side_ends_at(i, way) && !steps.side_ends_at(i + way, way))
                SideEnd(chain, i, way, steps.of_side(i, way)).judge();
}

}  // namespace cmm::fitting
