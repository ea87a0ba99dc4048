// SPDX-License-Identifier: Apache-2.0
#include "fitting/outliers.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "fitting/kinks.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
constexpr double scatter_factor = 7.0;   // times the robust sigma of the residuals
constexpr double texture_factor = 1.4;   // local over global scatter from which the local one counts
constexpr double quadruple_gain = 1.39;  // sigma of a residual / sigma of a point, equal spacing: sqrt(1 + 34/36)
constexpr int deepest = 6;               // points of one cluster that are removed together
constexpr double run_cost = 0.8, point_cost = 0.2;  // in units of one residual at its threshold, squared
constexpr std::size_t longest_run = 4;              // of adjacent bad points: a longer one is a feature of the part
constexpr std::size_t widest_region = 48;           // bits of the removed-set mask
constexpr double corner_share = 1.0;                // of the threshold: so near must a point continue a side
constexpr double fine_step_mm = 0.045;              // below, even a jump of 4/mm costs the cubic less than 0.5 um
constexpr double sparse_step_mm = 0.04;             // from this spacing on all points are one chain
constexpr std::size_t least_chain = 200;
constexpr double largest_share = 0.2;  // more bad points than this: the chain is no curve, stop looking

class Finder {
  public:
    Finder(std::span<const Vec2> points, bool closed, double floor)
        : points_(points), closed_(closed), n_(points.size()), prev_(n_), next_(n_), alive_(n_, 1) {
        for (std::size_t i = 0; i < n_; ++i) {
            prev_[i] = i > 0 ? i - 1 : (closed ? n_ - 1 : none);
            next_[i] = i + 1 < n_ ? i + 1 : (closed ? 0 : none);
        }
        residual_.resize(n_);
        for (std::size_t i = 0; i < n_; ++i)
            residual_[i] = residual_of(i);
        set_thresholds(floor);
    }

    BadPoints run() {
        std::vector<std::size_t> suspects;
        for (std::size_t i = 0; i < n_; ++i)
            if (ratio(i) > 1.0) suspects.push_back(i);
        budget_ = 40000 + 20 * n_;
        const auto limit = static_cast<std::size_t>(largest_share * static_cast<double>(n_));
        while (removed_ < limit) {
            std::size_t worst = none;
            for (const std::size_t i : suspects)
                if (alive_[i] && ratio(i) > 1.0 && (worst == none || ratio(i) > ratio(worst))) worst = i;
            if (worst == none) break;
            repair(worst);
            for (const std::size_t i : region_)
                if (alive_[i] && ratio(i) > 1.0) suspects.push_back(i);
        }
        return report();
    }

  private:
    /// Residual over what is excused, which grows with the gap that removed neighbours leave around the point.
    double ratio(std::size_t i) const {
        double excused = threshold_[i];
        if (jump_[i] > 0.0 && prev_[i] != none && next_[i] != none)
            excused += jump_[i] * std::max(0.0, (points_[next_[i]] - points_[prev_[i]]).squaredNorm() / gap_[i] - 1.0);
        return std::abs(residual_[i]) / excused;
    }

    /// The next living point beyond `from` that is not closer to it than `apart`; gives up after four.
    std::size_t beyond(std::size_t from, const std::vector<std::size_t>& step, double apart) const {
        std::size_t at = step[from];
        for (int tries = 0; tries < 3 && at != none; ++tries) {
            if ((points_[at] - points_[from]).squaredNorm() >= apart * apart) break;
            if (step[at] == none) break;
            at = step[at];
        }
        return at;
    }

    double residual_of(std::size_t i) const {
        const std::size_t b = prev_[i], c = next_[i];
        if (b == none || c == none) return 0.0;
        // Slopes over a much shorter base than the gap would only amplify noise.
        const double apart = 0.35 * (points_[c] - points_[b]).norm();
        const std::size_t a = beyond(b, prev_, apart), d = beyond(c, next_, apart);
        if (a == none || d == none || a == c || d == b || a == d) return 0.0;
        return spline_residual(points_[a], points_[b], points_[c], points_[d], points_[i]);
    }

    /// The q-quantile of `from` over the points low ... high of the chain (offsets from `centre`, wrapped when closed).
    double quantile(const std::vector<double>& from, std::size_t centre, std::ptrdiff_t low, std::ptrdiff_t high,
                    double q) {
        work_.clear();
        const auto n = static_cast<std::ptrdiff_t>(n_), middle = static_cast<std::ptrdiff_t>(centre);
        for (std::ptrdiff_t k = middle + low; k <= middle + high; ++k)
            if (closed_ || (k >= 0 && k < n)) work_.push_back(from[static_cast<std::size_t>((k % n + n) % n)]);
        if (work_.empty()) return 0.0;
        const auto nth = work_.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(work_.size() - 1));
        std::nth_element(work_.begin(), nth, work_.end());
        return *nth;
    }

    void set_thresholds(double floor) {
        threshold_.assign(n_, floor);
        jump_.assign(n_, 0.0);
        gap_.assign(n_, 1.0);
        std::vector<double> magnitude(n_), curvature(n_, 0.0), step(n_, 0.0);
        for (std::size_t i = 0; i < n_; ++i) {
            magnitude[i] = std::abs(residual_[i]);
            if (prev_[i] == none || next_[i] == none) continue;
            const Vec2 in = points_[i] - points_[prev_[i]], out = points_[next_[i]] - points_[i];
            step[i] = std::max(in.norm(), out.norm());
            curvature[i] = turn_angle(in, out) / (0.5 * (in.norm() + out.norm()));
        }
        const double overall = quantile(magnitude, 0, 0, static_cast<std::ptrdiff_t>(n_) - 1, 0.5) / 0.6745;
        sigma_ = overall / quadruple_gain;
        const auto reach = static_cast<std::ptrdiff_t>(std::min<std::size_t>(24, n_ / 4));
        double scatter = overall;
        for (std::size_t i = 0; i < n_; ++i) {
            // Four clean tenths are enough to see the noise among the five residuals that each bad point spoils.
            const double local = i % 8 == 0 ? quantile(magnitude, i, -reach, reach, 0.4) / 0.5244 : scatter;
            scatter = local > texture_factor * overall ? local : overall;
            const double sampling = sampling_error(curvature, step, i);
            threshold_[i] = std::max({floor, scatter_factor * scatter, 0.5 * scatter_factor * scatter + sampling});
        }
    }

    /// What the cubic of a good point's neighbours may miss by sampling alone. On a circle, steps h of angle g leave
    /// h g^3 / 6; where the curvature jumps by d (edge to side) h^2 d / 16. Twice and once that.
    double sampling_error(const std::vector<double>& curvature, const std::vector<double>& step, std::size_t i) {
        if (step[i] < fine_step_mm) return 0.0;
        const std::ptrdiff_t reach = n_ < 32 ? 3 : 7;
        // Medians on either side: the point itself and its bad neighbours have no say in what is excused.
        const double h = std::max(quantile(step, i, -reach, -1, 0.5), quantile(step, i, 1, reach, 0.5));
        const double before = quantile(curvature, i, -reach, -1, 0.5), after = quantile(curvature, i, 1, reach, 0.5);
        const double g = std::min(1.5, h * 0.5 * std::abs(before + after));
        jump_[i] = h * h * std::abs(after - before) / 16.0;
        gap_[i] = 4.0 * h * h;
        return h * g * g * g / 3.0 + jump_[i];
    }

    void kill(std::size_t i) {
        alive_[i] = 0;
        if (prev_[i] != none) next_[prev_[i]] = next_[i];
        if (next_[i] != none) prev_[next_[i]] = prev_[i];
    }

    void revive(std::size_t i) {
        alive_[i] = 1;
        if (prev_[i] != none) next_[prev_[i]] = i;
        if (next_[i] != none) prev_[next_[i]] = i;
    }

    using Saved = std::array<std::pair<std::size_t, double>, 6>;

    /// Recomputes the residuals of the three living neighbours on each side.
    Saved refresh_around(std::size_t i) {
        Saved saved;
        saved.fill({none, 0.0});
        std::size_t left = prev_[i], right = next_[i];
        for (std::size_t k = 0; k < 3; ++k) {
            if (left != none) {
                saved[2 * k] = {left, residual_[left]};
                residual_[left] = residual_of(left);
                left = prev_[left];
            }
            if (right != none) {
                saved[2 * k + 1] = {right, residual_[right]};
                residual_[right] = residual_of(right);
                right = next_[right];
            }
        }
        if (budget_ > 0) --budget_;
        return saved;
    }

    void restore(const Saved& saved) {
        for (auto entry = saved.rbegin(); entry != saved.rend(); ++entry)
            if (entry->first != none) residual_[entry->first] = entry->second;
    }

    void collect_region(std::size_t seed) {
        region_.clear();
        const auto walk = [&](const std::vector<std::size_t>& step) {
            std::size_t quiet = 0, at = step[seed];
            std::vector<std::size_t> found;
            while (at != none && at != seed && quiet < 5 && found.size() < widest_region / 2 - 1) {
                found.push_back(at);
                quiet = ratio(at) > 1.0 ? 0 : quiet + 1;
                at = step[at];
            }
            return found;
        };
        const auto before = walk(prev_), after = walk(next_);
        region_.assign(before.rbegin(), before.rend());
        region_.push_back(seed);
        for (const std::size_t i : after)
            if (std::find(region_.begin(), region_.end(), i) == region_.end()) region_.push_back(i);
    }

    /// Bad points come in runs: a second run is less likely than a longer one.
    static double cost_of(std::uint64_t mask) {
        return run_cost * std::popcount(mask & ~(mask << 1U)) + point_cost * std::popcount(mask);
    }

    void explore(int left, std::uint64_t mask) {
        std::size_t worst = none;
        double score = cost_of(mask);
        for (const std::size_t i : region_) {
            if (!alive_[i]) continue;
            score += ratio(i) * ratio(i);
            if (worst == none || ratio(i) > ratio(worst)) worst = i;
        }
        if (worst == none || ratio(worst) <= 1.0) {
            if (score < best_score_) {
                best_score_ = score;
                best_mask_ = mask;
            }
            return;
        }
        if (left == 0 || budget_ == 0 || cost_of(mask) + point_cost >= best_score_) return;
        // The worst residual involves five points; one of them at least is bad.
        const std::size_t p = prev_[worst], q = next_[worst];
        for (const std::size_t i : {worst, p, q, p != none ? prev_[p] : none, q != none ? next_[q] : none}) {
            const auto found = std::find(region_.begin(), region_.end(), i);
            if (i == none || found == region_.end() || !alive_[i] || longest_run_with(i) > longest_run) continue;
            const std::uint64_t with = mask | (std::uint64_t{1} << (found - region_.begin()));
            if (std::find(visited_.begin(), visited_.end(), with) != visited_.end()) continue;
            visited_.push_back(with);
            kill(i);
            const Saved saved = refresh_around(i);
            explore(left - 1, with);
            restore(saved);
            revive(i);
        }
    }

    /// Consecutive points that would be missing with i.
    std::size_t longest_run_with(std::size_t i) const {
        if (prev_[i] == none || next_[i] == none) return 1;
        return (next_[i] + n_ - prev_[i]) % n_ - 1;
    }

    /// The cheapest explanation of the region: removals have a price, and so have residuals that stay. When no
    /// few points explain it, the shape does (a kink, sparse sampling), and what passes for a residual there is raised.
    void repair(std::size_t seed) {
        collect_region(seed);
        best_score_ = std::numeric_limits<double>::infinity();
        for (int depth = 1; depth <= deepest && best_score_ > run_cost + point_cost * depth; ++depth) {
            visited_.clear();
            explore(depth, 0);
        }
        if (!std::isfinite(best_score_)) {
            for (const std::size_t i : region_)
                threshold_[i] *= 1.5;
            return;
        }
        for (std::size_t k = 0; k < region_.size(); ++k) {
            if (!((best_mask_ >> k) & 1U)) continue;
            kill(region_[k]);
            refresh_around(region_[k]);
            ++removed_;
        }
    }

    /// The links of a removed point are of its time: walk on to living neighbours.
    void refresh_links() {
        for (std::size_t i = 0; i < n_; ++i) {
            if (alive_[i]) continue;
            while (prev_[i] != none && !alive_[prev_[i]])
                prev_[i] = prev_[prev_[i]];
            while (next_[i] != none && !alive_[next_[i]])
                next_[i] = next_[next_[i]];
        }
    }

    /// Gives points back that only a corner of the curve has made look bad.
    void excuse_corners() {
        std::vector<Vec2> cluster, before, after;
        for (std::size_t first = 0; first < n_; ++first) {
            // The first of a cluster: its predecessor in the chain lives.
            if (alive_[first] || prev_[first] == none || next_[first] == none || (prev_[first] + 1) % n_ != first)
                continue;
            const std::size_t end = next_[first];
            cluster.clear();
            double tolerance = threshold_[first];
            for (std::size_t i = first; i != end; i = (i + 1) % n_) {
                cluster.push_back(points_[i]);
                tolerance = std::min(tolerance, threshold_[i]);
            }
            collect(prev_[first], prev_, before);
            collect(end, next_, after);
            if (!continues_a_side(cluster, before, after, corner_share * tolerance)) continue;
            for (std::size_t i = first; i != end; i = (i + 1) % n_) {
                corner_[i] = 1;
                alive_[i] = 1;
                --removed_;
            }
        }
    }

    void collect(std::size_t from, const std::vector<std::size_t>& step, std::vector<Vec2>& side) const {
        side.clear();
        for (std::size_t i = from; i != none && side.size() < 5; i = step[i])
            side.push_back(points_[i]);
    }

    BadPoints report() {
        refresh_links();
        corner_.assign(n_, 0);
        excuse_corners();
        BadPoints out;
        out.bad.resize(n_);
        for (std::size_t i = 0; i < n_; ++i) {
            out.bad[i] = static_cast<char>(!alive_[i]);
            if (!alive_[i] || corner_[i]) residual_[i] = residual_of(i);
        }
        out.corner = std::move(corner_);
        out.residual = std::move(residual_);
        out.threshold_mm = std::move(threshold_);
        out.sigma_mm = sigma_;
        out.count = removed_;
        return out;
    }

    std::span<const Vec2> points_;
    bool closed_;
    std::size_t n_;
    std::vector<std::size_t> prev_, next_;  // living neighbours
    std::vector<char> alive_, corner_;
    std::vector<double> residual_, threshold_, work_;
    std::vector<double> jump_, gap_;  // error of the cubic where the curvature jumps, and the squared gap it is for
    std::vector<std::size_t> region_;
    std::vector<std::uint64_t> visited_;
    double best_score_ = 0.0, sigma_ = 0.0;
    std::uint64_t best_mask_ = 0;
    std::size_t removed_ = 0, budget_ = 0;
};

}  // namespace

BadPoints find_bad_points(std::span<const Vec2> points, bool closed, double floor_mm) {
    const std::size_t n = points.size();
    BadPoints all;
    all.bad.assign(n, 0);
    all.corner.assign(n, 0);
    all.residual.assign(n, 0.0);
    all.threshold_mm.assign(n, floor_mm);
    if (n < 7) return all;
    // Points much denser than bad points are high lie close to their bad neighbours, whatever the spline does. Taking
    // every k-th point in k interleaved chains restores the proportions, and makes singles out of runs.
    const std::vector<double> s = chord_parameters(points, false);
    const double mean_step = s.back() / static_cast<double>(n);
    const auto chains = std::clamp<std::size_t>(static_cast<std::size_t>(sparse_step_mm / std::max(mean_step, 1e-9)), 1,
                                                std::max<std::size_t>(1, n / least_chain));
    std::vector<Vec2> chain;
    for (std::size_t first = 0; first < chains; ++first) {
        chain.clear();
        for (std::size_t i = first; i < n; i += chains)
            chain.push_back(points[i]);
        const BadPoints found = Finder(chain, closed, floor_mm).run();
        for (std::size_t k = 0, i = first; i < n; ++k, i += chains) {
            all.bad[i] = found.bad[k];
            all.corner[i] = found.corner[k];
            all.residual[i] = found.residual[k];
            all.threshold_mm[i] = found.threshold_mm[k];
        }
        all.count += found.count;
        all.sigma_mm += found.sigma_mm / static_cast<double>(chains);
    }
    return all;
}

}  // namespace cmm::fitting
