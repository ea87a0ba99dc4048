// SPDX-License-Identifier: Apache-2.0
#include "fitting/outliers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "fitting/bridge.hpp"
#include "fitting/spline_residual.hpp"

namespace cmm::fitting {
namespace {

constexpr double suspect_factor = 3.5;  // times the standard deviation of a residual: looked at closely
constexpr double reject_factor = 5.0;   // of a prediction: bad
constexpr double sure_factor = 3.0;     // of a prediction: good
constexpr double clear_factor = 2.0;    // of a prediction over a wider gap: good
constexpr double clear_sd = 4.0;        // in sigmas: of such a prediction
constexpr double witness_sd = 8.0;      // in sigmas: of a prediction that frees a point at the first hearing
constexpr double texture_factor = 1.4;  // local over global scatter from which the local one counts
constexpr double sharp_turn_rad = 0.6;  // from chord to chord; a steep run turns so where the cubic goes astray
constexpr double apart_share = 0.35;    // of the gap: slopes over a shorter base would only amplify noise
constexpr double stride_sigmas = 15.0;  // a step shorter than this has no direction
constexpr std::size_t longest_stride = 16;
constexpr std::size_t block = 16;  // points that share their scatter and stride
constexpr std::ptrdiff_t half_a_block = 8;
constexpr std::ptrdiff_t reach = 2;      // neighbours a side in the test: so far a suspect may accuse
constexpr std::ptrdiff_t merge_gap = 3;  // accused stretches nearer than this are one
constexpr std::size_t longest_run = 5;   // of adjacent bad points: a longer one is a feature of the part
constexpr std::size_t many = 4;          // bad points of a stretch: another explanation is looked for
constexpr std::size_t least_points = 7;
constexpr int most_rounds = 3;

enum class State : std::uint8_t { good, accused, bad };

class Finder {
  public:
    Finder(std::span<const Vec2> points, bool closed, double floor)
        : points_(points), closed_(closed), n_(static_cast<std::ptrdiff_t>(points.size())), floor_(floor) {
        const std::size_t n = points.size();
        state_.assign(n, State::good);
        corner_.assign(n, 0);
        residual_.assign(n, 0.0);
        threshold_.assign(n, 0.0);
        ratio_.assign(n, 0.0);
        gain_.assign(n, 1.0);
        settled_at_.assign(n, 1e9);
        stride_.assign(n / block + 1, 1);
        scatter_.assign(n / block + 1, 0.0);
    }

    BadPoints run() {
        test(0, n_ - 1);
        estimate_scatter();
        if (set_strides()) {
            test(0, n_ - 1);
            estimate_scatter();
        }
        // What is found makes the scatter smaller, and more stands out.
        for (int round = 0; round < most_rounds && accuse(); ++round) {
            for (const auto& [low, high] : stretches_)
                if (!convict(low, high)) hear(low, high);
            for (const auto& [low, high] : stretches_)
                test(low - reach, high + reach);
            estimate_scatter();
        }
        return report();
    }

  private:
    std::ptrdiff_t wrapped(std::ptrdiff_t i) const { return closed_ ? (i % n_ + n_) % n_ : i; }
    bool exists(std::ptrdiff_t i) const { return closed_ || (i >= 0 && i < n_); }
    const Vec2& point(std::ptrdiff_t i) const { return points_[static_cast<std::size_t>(wrapped(i))]; }
    State& state(std::ptrdiff_t i) { return state_[static_cast<std::size_t>(wrapped(i))]; }
    std::size_t block_of(std::ptrdiff_t i) const { return static_cast<std::size_t>(wrapped(i)) / block; }

    /// Standard deviation of a point, so that the floor is never undercut.
    double sigma_at(std::ptrdiff_t i) const { return std::max(scatter_[block_of(i)], floor_ / reject_factor); }

    /// The next good point beyond `from`; n_ when there is none near. Points nearer to `from` than `apart` are passed
    /// over, at most three of them.
    std::ptrdiff_t good_beyond(std::ptrdiff_t from, std::ptrdiff_t step, double apart) {
        std::ptrdiff_t found = none;
        int passed = 0;
        for (std::ptrdiff_t at = from + step, walked = 0; walked < 24 && exists(at); at += step, ++walked) {
            if (state(at) != State::good) continue;
            found = at;
            if (apart <= 0.0 || (point(at) - point(from)).squaredNorm() >= apart * apart || ++passed > 3) break;
        }
        return found;
    }

    SplineResidual test(std::ptrdiff_t i) {
        const std::ptrdiff_t step = stride_[block_of(i)];
        if (i >= 2 * step && i + 2 * step < n_) {
            // Almost always all four are good and well apart.
            const auto at = static_cast<std::size_t>(i), by = static_cast<std::size_t>(step);
            const bool good = state_[at - 2 * by] == State::good && state_[at - by] == State::good &&
                              state_[at + by] == State::good && state_[at + 2 * by] == State::good;
            const Vec2 &a = points_[at - 2 * by], &b = points_[at - by], &c = points_[at + by],
                       &d = points_[at + 2 * by];
            const double least = apart_share * apart_share * (c - b).squaredNorm();
            if (good && (b - a).squaredNorm() >= least && (d - c).squaredNorm() >= least)
                return spline_residual(a, b, c, d, points_[at]);
        }
        const std::ptrdiff_t b = good_beyond(i, -step, 0.0), c = good_beyond(i, step, 0.0);
        if (b == none || c == none) return {};
        const double apart = apart_share * (point(c) - point(b)).norm();
        const std::ptrdiff_t a = good_beyond(b, -step, apart), d = good_beyond(c, step, apart);
        if (a == none || d == none || (closed_ && d - a >= n_)) return {};
        return spline_residual(point(a), point(b), point(c), point(d), point(i));
    }

    void test(std::ptrdiff_t low, std::ptrdiff_t high) {
        for (std::ptrdiff_t i = low; i <= high; ++i) {
            if (!exists(i) || state(i) == State::bad) continue;
            const SplineResidual found = test(i);
            const auto at = static_cast<std::size_t>(wrapped(i));
            residual_[at] = found.distance_mm;
            gain_[at] = found.gain;
            threshold_[at] = 0.0;
            ratio_[at] = std::abs(found.distance_mm) / found.gain;
        }
    }

    /// Of the good points' ratios from low up to high.
    double quantile(std::ptrdiff_t low, std::ptrdiff_t high, double q) {
        work_.clear();
        for (std::ptrdiff_t k = low; k < high; ++k)
            if (exists(k) && state(k) == State::good) work_.push_back(ratio_[static_cast<std::size_t>(wrapped(k))]);
        if (work_.empty()) return 0.0;
        const auto nth = work_.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(work_.size() - 1));
        std::nth_element(work_.begin(), nth, work_.end());
        return *nth;
    }

    /// Four clean tenths are enough to see the noise among the residuals that each bad point spoils. Only where fewer
    /// than four tenths are small is it worth while to look what the local scatter is.
    void estimate_scatter() {
        sigma_ = quantile(0, n_, 0.5) / 0.6745;
        const double small = texture_factor * 0.5244 * sigma_;
        const std::size_t blocks = scatter_.size();
        std::vector<std::size_t> all(blocks, 0), quiet(blocks, 0);
        for (std::size_t i = 0; i < points_.size(); ++i) {
            if (state_[i] != State::good) continue;
            ++all[i / block];
            quiet[i / block] += ratio_[i] <= small;
        }
        for (std::size_t k = 0; k < blocks; ++k) {
            const auto sum = [&](const std::vector<std::size_t>& counts) {
                const std::size_t before = k > 0 ? counts[k - 1] : (closed_ ? counts[blocks - 1] : 0);
                const std::size_t after = k + 1 < blocks ? counts[k + 1] : (closed_ ? counts[0] : 0);
                return before + counts[k] + after;
            };
            scatter_[k] = sigma_;
            if (10 * sum(quiet) >= 4 * sum(all)) continue;
            const auto low = static_cast<std::ptrdiff_t>(k * block), reach_out = static_cast<std::ptrdiff_t>(block);
            scatter_[k] = std::max(sigma_, quantile(low - reach_out, low + 2 * reach_out, 0.4) / 0.5244);
        }
    }

    /// Where steps are not clearly longer than the noise, every k-th point is a neighbour. False when there is no such
    /// place.
    bool set_strides() {
        bool any = false;
        for (std::size_t k = 0; k < stride_.size(); ++k) {
            work_.clear();
            const auto low = static_cast<std::ptrdiff_t>(k * block);
            for (std::ptrdiff_t i = low; i < low + static_cast<std::ptrdiff_t>(block); ++i)
                if (exists(i) && exists(i + 1)) work_.push_back((point(i + 1) - point(i)).norm());
            if (work_.empty()) continue;
            const auto nth = work_.begin() + static_cast<std::ptrdiff_t>(work_.size() / 2);
            std::nth_element(work_.begin(), nth, work_.end());
            const double wanted = std::ceil(stride_sigmas * scatter_[k] / std::max(*nth, 1e-9));
            const auto most = static_cast<double>(std::clamp<std::ptrdiff_t>(n_ / 100, 1, longest_stride));
            stride_[k] = static_cast<std::ptrdiff_t>(std::clamp(wanted, 1.0, most));
            any = any || stride_[k] > 1;
        }
        return any;
    }

    /// A point that was settled is settled as long as the scatter has not become clearly smaller.
    bool suspicious(std::ptrdiff_t i) {
        const std::size_t at = static_cast<std::size_t>(wrapped(i));
        if (state(i) == State::bad || sigma_at(i) > 0.8 * settled_at_[at]) return false;
        if (ratio_[at] > suspect_factor * sigma_at(i)) return true;
        if (!exists(i - 1) || !exists(i + 1)) return false;
        const Vec2 in = point(i) - point(i - 1), out = point(i + 1) - point(i);
        if (std::abs(cross(in, out)) <= sharp_turn_rad * in.dot(out)) return false;
        const double shortest = std::sqrt(std::min(in.squaredNorm(), out.squaredNorm()));
        const double limit = sharp_turn_rad + 5.0 * 2.4 * sigma_at(i) / std::max(shortest, 1e-9);
        return limit < 3.0 && std::abs(cross(in, out)) > std::tan(std::min(limit, 1.5)) * in.dot(out);
    }

    /// Every suspect accuses the neighbours that its test rests on, and itself. False when there is none.
    bool accuse() {
        stretches_.clear();
        for (std::ptrdiff_t i = 0; i < n_; ++i) {
            if (!suspicious(i)) continue;
            const std::ptrdiff_t by = reach * stride_[block_of(i)];
            hold(stretches_, i - by, i + by);
        }
        if (closed_ && stretches_.size() > 1 && stretches_.front().first + n_ <= stretches_.back().second + merge_gap) {
            stretches_.front().first = std::min(stretches_.front().first, stretches_.back().first - n_);
            stretches_.pop_back();
        }
        for (auto& [low, high] : stretches_) {
            if (closed_) {
                high = std::min(high, low + n_ - 1);
            } else {
                low = std::max<std::ptrdiff_t>(low, 0);
                high = std::min(high, n_ - 1);
            }
            for (std::ptrdiff_t i = low; i <= high; ++i)
                if (state(i) == State::good) state(i) = State::accused;
        }
        return !stretches_.empty();
    }

    Neighbours neighbours_of(std::ptrdiff_t i) {
        Neighbours near;
        const std::ptrdiff_t step = stride_[block_of(i)];
        const auto collect = [&](std::ptrdiff_t direction, std::array<Vec2, Neighbours::most>& out,
                                 std::size_t& count) {
            std::ptrdiff_t since = step;  // the nearest one counts at once
            const std::ptrdiff_t walk = 24 + static_cast<std::ptrdiff_t>(Neighbours::most) * step;
            for (std::ptrdiff_t at = i + direction, walked = 0; walked < walk && exists(at) && count < out.size();
                 at += direction, ++walked) {
                if (closed_ && std::abs(at - i) > n_ / 2) break;
                if (state(at) != State::good || ++since < step) continue;
                out[count++] = point(at);
                since = 0;
            }
        };
        collect(-1, near.before, near.count_before);
        collect(1, near.after, near.count_after);
        return near;
    }

    Verdict judge(std::ptrdiff_t i) {
        double sigma = sigma_at(i);
        for (const std::ptrdiff_t by : {-half_a_block, half_a_block})
            if (exists(i + by)) sigma = std::max(sigma, sigma_at(i + by));
        return judge_point(neighbours_of(i), point(i), sigma);
    }

    void note(std::ptrdiff_t i, State state_now, const Verdict& verdict) {
        const auto at = static_cast<std::size_t>(wrapped(i));
        state_[at] = state_now;
        corner_[at] = static_cast<char>(state_now == State::good && verdict.corner);
        residual_[at] = verdict.residual_mm;
        threshold_[at] = reject_factor * verdict.sd_mm;
    }

    /// Worst first (A9), as long as both sides together clear or convict the worst sharply. False when they do not.
    bool convict(std::ptrdiff_t low, std::ptrdiff_t high) {
        for (std::ptrdiff_t i = low; i <= high; ++i)
            if (state(i) == State::accused) state(i) = State::good;
        while (true) {
            std::ptrdiff_t worst = none;
            double ratio = 0.0;
            for (std::ptrdiff_t i = low; i <= high; ++i) {
                const double now = ratio_[static_cast<std::size_t>(wrapped(i))];
                if (now <= ratio || !suspicious(i)) continue;
                worst = i;
                ratio = now;
            }
            if (worst == none) break;
            const Verdict verdict = judge(worst);
            if (!verdict.sharp) break;
            settled_at_[static_cast<std::size_t>(wrapped(worst))] = sigma_at(worst);
            if (std::abs(verdict.ratio()) <= reject_factor) continue;
            note(worst, State::bad, verdict);
            const std::ptrdiff_t by = 3 * stride_[block_of(worst)];
            test(worst - by, worst + by);
        }
        for (std::ptrdiff_t i = low; i <= high; ++i)
            if (suspicious(i)) return false;
        for (std::ptrdiff_t i = low; i <= high; ++i)
            settled_at_[static_cast<std::size_t>(wrapped(i))] = sigma_at(i);
        return true;
    }

    /// Judges every accused point of a stretch among all others: the clearly bad ones go first, the worst before all.
    /// What then agrees and is not next to what does not is free.
    void hear(std::ptrdiff_t low, std::ptrdiff_t high) {
        verdicts_.assign(static_cast<std::size_t>(high - low + 1), {});
        const auto verdict = [&](std::ptrdiff_t i) -> Verdict& { return verdicts_[static_cast<std::size_t>(i - low)]; };
        std::ptrdiff_t from = low, to = high;
        for (std::ptrdiff_t removed = 0; 2 * removed <= high - low; ++removed) {
            for (std::ptrdiff_t i = from; i <= to; ++i) {
                if (state(i) != State::good) continue;
                verdict(i) = judge(i);
                note(i, State::good, verdict(i));
            }
            std::ptrdiff_t worst = none;
            for (std::ptrdiff_t i = low; i <= high; ++i)
                if (state(i) == State::good && verdict(i).sharp && std::abs(verdict(i).ratio()) > reject_factor &&
                    (worst == none || std::abs(verdict(i).ratio()) > std::abs(verdict(worst).ratio())))
                    worst = i;
            if (worst == none) break;
            note(worst, State::bad, verdict(worst));
            const std::ptrdiff_t by = static_cast<std::ptrdiff_t>(Neighbours::most) * stride_[block_of(worst)];
            from = std::max(low, worst - by);
            to = std::min(high, worst + by);
        }
        std::vector<std::pair<std::ptrdiff_t, std::ptrdiff_t>> held;
        for (std::ptrdiff_t i = low; i <= high; ++i) {
            // A wide prediction is no witness for a point far off it.
            const double wide = std::min(verdict(i).sd_mm, witness_sd * sigma_at(i));
            const bool agrees = verdict(i).resolved && std::abs(verdict(i).residual_mm) <= reject_factor * wide;
            if (state(i) == State::bad || agrees) continue;
            const std::ptrdiff_t by = reach * stride_[block_of(i)];
            hold(held, std::max(low, i - by), std::min(high, i + by));
        }
        for (const auto& [first, last] : held)
            for (std::ptrdiff_t i = first; i <= last; ++i)
                if (state(i) == State::good) state(i) = State::accused;
        for (const auto& [first, last] : held)
            settle(first, last);
        for (std::ptrdiff_t i = low; i <= high; ++i)
            settled_at_[static_cast<std::size_t>(wrapped(i))] = sigma_at(i);
    }

    static void hold(std::vector<std::pair<std::ptrdiff_t, std::ptrdiff_t>>& stretches, std::ptrdiff_t low,
                     std::ptrdiff_t high) {
        if (!stretches.empty() && low <= stretches.back().second + merge_gap) {
            stretches.back().second = high;
        } else {
            stretches.emplace_back(low, high);
        }
    }

    /// Looks for the bad points among the accused `low` ... `high`: by letting the good ones come back and, when that
    /// leaves many out, by taking the worst away; the smaller set explains the stretch.
    void settle(std::ptrdiff_t low, std::ptrdiff_t high) {
        grow(low, high);
        if (longest_open() > longest_run) {
            const std::vector<std::ptrdiff_t> grown = open_;
            weed(low, high);
            if (open_.size() >= grown.size() || longest_open() > longest_run) {
                open_ = grown;
                if (longest_open() > longest_run) open_.clear();  // so long a run is a feature of the part
                for (std::ptrdiff_t i = low; i <= high; ++i)
                    state(i) = State::good;
                for (const std::ptrdiff_t i : open_)
                    state(i) = State::accused;
                for (const std::ptrdiff_t i : open_)
                    note(i, State::accused, judge(i));
                for (const std::ptrdiff_t i : open_)
                    state(i) = State::bad;
            }
        }
        verify(low, high);
    }

    std::size_t longest_open() const {
        std::size_t longest = 0, run = 0;
        for (std::size_t k = 0; k < open_.size(); ++k) {
            run = k > 0 && open_[k] == open_[k - 1] + 1 ? run + 1 : 1;
            longest = std::max(longest, run);
        }
        return longest;
    }

    /// Worst first, as long as one contradicts the others; who agrees again comes back.
    void weed(std::ptrdiff_t low, std::ptrdiff_t high) {
        for (std::ptrdiff_t i = low; i <= high; ++i)
            state(i) = State::good;
        open_.clear();
        while (static_cast<std::ptrdiff_t>(2 * open_.size()) <= high - low) {
            std::ptrdiff_t worst = none;
            Verdict found;
            for (std::ptrdiff_t i = low; i <= high; ++i) {
                const Verdict now = judge(i);
                note(i, state(i), now);
                if (state(i) != State::good ||
                    std::abs(now.ratio()) <= std::max(reject_factor, std::abs(found.ratio())))
                    continue;
                worst = i;
                found = now;
            }
            if (worst == none) break;
            note(worst, State::bad, found);
            open_.push_back(worst);
        }
        std::sort(open_.begin(), open_.end());
    }

    /// The accused come back from both ends as long as they are predicted, then from the middle; the doubtful last.
    void grow(std::ptrdiff_t low, std::ptrdiff_t high) {
        open_.clear();
        for (std::ptrdiff_t i = low; i <= high; ++i)
            if (state(i) == State::accused) open_.push_back(i);
        do
            take_from_ends();
        while (!open_.empty() && take_from_middle());
        for (std::size_t k = 0; k < open_.size(); ++k)
            if (!verdicts_[k].resolved) verdicts_[k] = judge_unresolved(open_[k]);
        std::size_t left = 0;
        for (std::size_t k = 0; k < open_.size(); ++k) {
            const bool bad = std::abs(verdicts_[k].ratio()) > reject_factor;
            note(open_[k], bad ? State::bad : State::good, verdicts_[k]);
            if (bad) open_[left++] = open_[k];
        }
        open_.resize(left);
    }

    /// The first or the last open point comes back, whichever is surer, until neither is predicted well.
    void take_from_ends() {
        if (open_.empty()) return;
        std::size_t first = 0, last = open_.size();
        const auto is_sure = [](const Verdict& verdict) {
            return verdict.resolved && std::abs(verdict.ratio()) <= sure_factor;
        };
        Verdict left = judge(open_[first]), right = judge(open_[last - 1]);
        while (first < last && (is_sure(left) || is_sure(right))) {
            if (is_sure(left) && (!is_sure(right) || farthest(left) <= farthest(right))) {
                note(open_[first++], State::good, left);
                if (first < last) left = judge(open_[first]);
            } else {
                note(open_[--last], State::good, right);
                if (first < last) right = judge(open_[last - 1]);
            }
        }
        open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(last), open_.end());
        open_.erase(open_.begin(), open_.begin() + static_cast<std::ptrdiff_t>(first));
    }

    /// How far from its prediction a point may be.
    static double farthest(const Verdict& verdict) {
        return std::abs(verdict.residual_mm) + sure_factor * verdict.sd_mm;
    }

    /// Judges all open points over the whole gap. Those that fit without doubt come back together, otherwise the one
    /// that is surest to lie near its prediction.
    bool take_from_middle() {
        verdicts_.clear();
        std::size_t best = open_.size();
        bool any = false;
        for (std::size_t k = 0; k < open_.size(); ++k) {
            verdicts_.push_back(judge(open_[k]));
            const Verdict& now = verdicts_.back();
            any = any || clear(now, open_[k]);
            if (!now.resolved || std::abs(now.ratio()) > reject_factor) continue;
            if (best < open_.size() && farthest(now) >= farthest(verdicts_[best])) continue;
            best = k;
        }
        if (!any && best == open_.size()) return false;
        std::size_t left = 0;
        for (std::size_t k = 0; k < open_.size(); ++k) {
            if (any ? clear(verdicts_[k], open_[k]) : k == best) {
                note(open_[k], State::good, verdicts_[k]);
            } else {
                open_[left++] = open_[k];
            }
        }
        open_.resize(left);
        return true;
    }

    bool clear(const Verdict& verdict, std::ptrdiff_t i) const {
        return verdict.resolved && !verdict.corner && std::abs(verdict.ratio()) < clear_factor &&
               verdict.sd_mm < clear_sd * sigma_at(i);
    }

    /// Where the neighbours are no witnesses the sampling does not resolve the shape: there the four-neighbour test
    /// decides, less what sampling alone can cause.
    Verdict judge_unresolved(std::ptrdiff_t i) {
        Verdict out;
        const SplineResidual found = test(i);
        out.residual_mm = found.distance_mm;
        out.sd_mm = found.gain * sigma_at(i) + sampling_error(i) / reject_factor;
        return out;
    }

    /// What the cubic of a good point's neighbours may miss by sampling alone. On a circle, steps h of angle g leave
    /// h g^3 / 6; where the curvature jumps by d (edge to side) h^2 d / 16. Twice and once that.
    double sampling_error(std::ptrdiff_t i) {
        std::array<double, 2> step{}, curvature{};
        for (const int side : {0, 1}) {
            std::vector<double> steps, bends;
            std::ptrdiff_t before = good_beyond(i, side == 0 ? -1 : 1, 0.0), at = before;
            for (int k = 0; k < 7 && at != none; ++k) {
                const std::ptrdiff_t next = good_beyond(at, side == 0 ? -1 : 1, 0.0);
                if (next == none) break;
                if (at != before) {
                    const Vec2 in = point(at) - point(before), out = point(next) - point(at);
                    steps.push_back(std::max(in.norm(), out.norm()));
                    bends.push_back((side == 0 ? -1.0 : 1.0) * turn_angle(in, out) /
                                    std::max(0.5 * (in.norm() + out.norm()), 1e-12));
                }
                before = at;
                at = next;
            }
            if (steps.empty()) continue;
            const auto middle = static_cast<std::ptrdiff_t>(steps.size() / 2);
            std::nth_element(steps.begin(), steps.begin() + middle, steps.end());
            std::nth_element(bends.begin(), bends.begin() + middle, bends.end());
            step[side] = steps[middle];
            curvature[side] = bends[middle];
        }
        const std::ptrdiff_t b = good_beyond(i, -1, 0.0), c = good_beyond(i, 1, 0.0);
        if (b == none || c == none) return 0.0;
        const double gap = (point(c) - point(b)).norm();
        const double h = std::max({step[0], step[1], 0.5 * gap}),
                     g = std::min(1.5, 0.5 * h * std::abs(curvature[0] + curvature[1]));
        return h * g * g * g / 3.0 + h * h * std::abs(curvature[0] - curvature[1]) / 16.0;
    }

    /// The good points of a settled stretch once more, with their final neighbours: worst first.
    void verify(std::ptrdiff_t low, std::ptrdiff_t high) {
        for (std::size_t tries = 0; tries < longest_run; ++tries) {
            std::ptrdiff_t worst = none;
            Verdict found;
            for (std::ptrdiff_t i = low; i <= high; ++i) {
                if (state(i) != State::good) continue;
                const SplineResidual again = test(i);
                if (std::abs(again.distance_mm) <= suspect_factor * again.gain * sigma_at(i)) continue;
                const Verdict verdict = judge(i);
                if (!verdict.resolved || std::abs(verdict.ratio()) <= reject_factor) continue;
                if (worst != none && std::abs(verdict.ratio()) <= std::abs(found.ratio())) continue;
                worst = i;
                found = verdict;
            }
            if (worst == none) break;
            note(worst, State::bad, found);
        }
    }

    BadPoints report() {
        BadPoints out;
        out.bad.resize(points_.size());
        for (std::size_t i = 0; i < points_.size(); ++i) {
            out.bad[i] = static_cast<char>(state_[i] == State::bad);
            out.count += state_[i] == State::bad;
            if (threshold_[i] <= 0.0)
                threshold_[i] = reject_factor * gain_[i] * sigma_at(static_cast<std::ptrdiff_t>(i));
        }
        out.corner = std::move(corner_);
        out.residual = std::move(residual_);
        out.threshold_mm = std::move(threshold_);
        out.sigma_mm = sigma_;
        return out;
    }

    static constexpr std::ptrdiff_t none = PTRDIFF_MAX;
    std::span<const Vec2> points_;
    bool closed_;
    std::ptrdiff_t n_;
    double floor_, sigma_ = 0.0;
    std::vector<State> state_;
    std::vector<char> corner_;
    std::vector<double> residual_, threshold_, ratio_, gain_, work_;
    std::vector<double> settled_at_;      // the standard deviation at which a point was last judged
    std::vector<double> scatter_;         // by block: standard deviation of a point
    std::vector<std::ptrdiff_t> stride_;  // by block
    std::vector<std::pair<std::ptrdiff_t, std::ptrdiff_t>> stretches_;
    std::vector<std::ptrdiff_t> open_;
    std::vector<Verdict> verdicts_;
};

}  // namespace

BadPoints find_bad_points(std::span<const Vec2> points, bool closed, double floor_mm) {
    if (points.size() >= least_points) return Finder(points, closed, floor_mm).run();
    BadPoints all;
    all.bad.assign(points.size(), 0);
    all.corner.assign(points.size(), 0);
    all.residual.assign(points.size(), 0.0);
    all.threshold_mm.assign(points.size(), floor_mm);
    return all;
}

}  // namespace cmm::fitting
