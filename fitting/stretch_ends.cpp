// SPDX-License-Identifier: Apache-2.0
#include "fitting/stretch_ends.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "fitting/bridge.hpp"
#include "fitting/chain_state.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t farthest_neighbour = 24, searched = 24, beyond_searched = 8;  // points
constexpr double least_gap_steps = 2.0;                                             // of those beside it
constexpr int many_unheard = 3;  // wrongly accused ones together may have excused others

/// Where a closed chain ends at a gap: end, end + stride, ... go away from it.
class StretchEnd {
  public:
    StretchEnd(std::span<const Vec2> points, std::size_t end, bool forwards, double floor_mm, BadPoints& found)
        : points_(points), end_(end), forwards_(forwards), floor_mm_(floor_mm), found_(found) {}

    /// The `count` points nearest to the gap, the innermost first. False when no verdict changes.
    bool judge(std::size_t count) {
        bool any = false;
        int unheard = 0;
        for (std::size_t i = count; i-- > 0;) {
            const Verdict verdict = judge_point(neighbours_of(i), points_[at(i)], sigma_mm());
            unheard += verdict.resolved ? 0 : 1;
            const double threshold = ChainState::reject_factor * (verdict.resolved ? verdict.sd_mm : sigma_mm());
            any = note(i, std::abs(verdict.residual_mm) > threshold, verdict.residual_mm, threshold) || any;
        }
        if (unheard >= many_unheard) any = search() || any;
        return any;
    }

  private:
    std::size_t at(std::size_t i) const {
        const std::size_t n = points_.size();
        return forwards_ ? (end_ + i) % n : (end_ + n - i % n) % n;
    }
    double sigma_mm() const { return std::max(found_.sigma_mm, floor_mm_ / ChainState::reject_factor); }

    Neighbours neighbours_of(std::size_t i) const {
        Neighbours near;
        for (std::size_t k = i + 1; k <= i + farthest_neighbour && near.count_before < near.before.size(); ++k)
            if (found_.bad[at(k)] == 0) near.before[near.count_before++] = points_[at(k)];
        return near;
    }

    /// All of the end once more, as a chain of its own.
    bool search() {
        const std::size_t whole = std::min(searched + beyond_searched, points_.size() / 2);
        std::vector<Vec2> end;
        for (std::size_t i = whole; i-- > 0;)
            end.push_back(points_[at(i)]);
        const BadPoints alone = find_bad_points(end, false, floor_mm_);
        bool any = false;
        for (std::size_t i = 0; i < std::min(searched, whole); ++i) {
            const std::size_t k = whole - 1 - i;
            found_.corner[at(i)] = alone.corner[k];
            any = note(i, alone.bad[k] != 0, alone.residual[k], alone.threshold_mm[k]) || any;
        }
        return any;
    }

    /// `residual_mm` is positive on the right-hand side of the way to the gap.
    bool note(std::size_t i, bool bad, double residual_mm, double threshold_mm) {
        const std::size_t k = at(i);
        const bool changes = (found_.bad[k] != 0) != bad;
        found_.bad[k] = static_cast<char>(bad);
        found_.residual[k] = forwards_ ? -residual_mm : residual_mm;
        found_.threshold_mm[k] = threshold_mm;
        return changes;
    }

    std::span<const Vec2> points_;
    std::size_t end_;
    bool forwards_;
    double floor_mm_;
    BadPoints& found_;
};

}  // namespace

bool judge_ends(std::span<const Vec2> points, std::size_t before, std::size_t behind, double floor_mm,
                BadPoints& found) {
    const std::size_t n = points.size(), between = (behind + n - before - 1) % n;
    if (between == 0) return false;
    const Vec2 chord = (points[behind] - points[before]).normalized();
    const auto step = [&](std::size_t i) {
        return std::abs((points[(before + i + 1) % n] - points[(before + i) % n]).dot(chord));
    };
    double all = 0.0;
    std::size_t last = 0;  // before the gap: that is the widest step
    for (std::size_t i = 0; i <= between; ++i) {
        all += step(i);
        if (step(i) > step(last)) last = i;
    }
    // Where points lie all the way, only their verdicts have made the gap.
    if (step(last) < least_gap_steps * (all - step(last)) / static_cast<double>(between)) return false;
    const bool one = StretchEnd(points, (before + last) % n, false, floor_mm, found).judge(last);
    const bool other = StretchEnd(points, (before + last + 1) % n, true, floor_mm, found).judge(between - last);
    return one || other;
}

}  // namespace cmm::fitting
