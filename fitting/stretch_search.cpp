// SPDX-License-Identifier: Apache-2.0
#include "fitting/stretch_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr double sure_factor = 3.0;   // of a prediction: good
constexpr double clear_factor = 2.0;  // of a prediction over a wider gap: good
constexpr double clear_sd = 4.0;      // in sigmas: of such a prediction

/// How far from its prediction a point may be.
double farthest(const Verdict& verdict) {
    return std::abs(verdict.residual_mm) + sure_factor * verdict.sd_mm;
}

}  // namespace

void StretchSearch::settle(std::ptrdiff_t low, std::ptrdiff_t high) {
    grow(low, high);
    if (longest_open() > longest_bad_run) {
        const std::vector<std::ptrdiff_t> grown = open_;
        weed(low, high);
        if (open_.size() >= grown.size() || longest_open() > longest_bad_run) {
            open_ = grown;
            if (longest_open() > longest_bad_run) open_.clear();  // so long a run is a feature of the part
            for (std::ptrdiff_t i = low; i <= high; ++i)
                chain_.state(i) = PointState::good;
            for (const std::ptrdiff_t i : open_)
                chain_.state(i) = PointState::accused;
            for (const std::ptrdiff_t i : open_)
                chain_.note(i, PointState::accused, chain_.judge(i));
            for (const std::ptrdiff_t i : open_)
                chain_.state(i) = PointState::bad;
        }
    }
    verify(low, high);
}

std::size_t StretchSearch::longest_open() const {
    std::size_t longest = 0, run = 0;
    for (std::size_t k = 0; k < open_.size(); ++k) {
        run = k > 0 && open_[k] == open_[k - 1] + 1 ? run + 1 : 1;
        longest = std::max(longest, run);
    }
    return longest;
}

/// Worst first, as long as one contradicts the others; who agrees again comes back.
void StretchSearch::weed(std::ptrdiff_t low, std::ptrdiff_t high) {
    for (std::ptrdiff_t i = low; i <= high; ++i)
        chain_.state(i) = PointState::good;
    open_.clear();
    while (static_cast<std::ptrdiff_t>(2 * open_.size()) <= high - low) {
        std::ptrdiff_t worst = ChainState::none;
        Verdict found;
        for (std::ptrdiff_t i = low; i <= high; ++i) {
            const Verdict now = chain_.judge(i);
            chain_.note(i, chain_.state(i), now);
            if (chain_.state(i) != PointState::good ||
                std::abs(now.ratio()) <= std::max(ChainState::reject_factor, std::abs(found.ratio())))
                continue;
            worst = i;
            found = now;
        }
        if (worst == ChainState::none) break;
        chain_.note(worst, PointState::bad, found);
        open_.push_back(worst);
    }
    std::sort(open_.begin(), open_.end());
}

/// The accused come back from both ends as long as they are predicted, then from the middle; the doubtful last.
void StretchSearch::grow(std::ptrdiff_t low, std::ptrdiff_t high) {
    open_.clear();
    for (std::ptrdiff_t i = low; i <= high; ++i)
        if (chain_.state(i) == PointState::accused) open_.push_back(i);
    do
        take_from_ends();
    while (!open_.empty() && take_from_middle());
    for (std::size_t k = 0; k < open_.size(); ++k)
        if (!verdicts_[k].resolved) verdicts_[k] = judge_unresolved(open_[k]);
    std::size_t left = 0;
    for (std::size_t k = 0; k < open_.size(); ++k) {
        const bool bad = std::abs(verdicts_[k].ratio()) > ChainState::reject_factor;
        chain_.note(open_[k], bad ? PointState::bad : PointState::good, verdicts_[k]);
        if (bad) open_[left++] = open_[k];
    }
    open_.resize(left);
}

/// The first or the last open point comes back, whichever is surer, until neither is predicted well.
void StretchSearch::take_from_ends() {
    if (open_.empty()) return;
    std::size_t first = 0, last = open_.size();
    const auto is_sure = [](const Verdict& verdict) {
        return verdict.resolved && std::abs(verdict.ratio()) <= sure_factor;
    };
    Verdict left = chain_.judge(open_[first]), right = chain_.judge(open_[last - 1]);
    while (first < last && (is_sure(left) || is_sure(right))) {
        if (is_sure(left) && (!is_sure(right) || farthest(left) <= farthest(right))) {
            chain_.note(open_[first++], PointState::good, left);
            if (first < last) left = chain_.judge(open_[first]);
        } else {
            chain_.note(open_[--last], PointState::good, right);
            if (first < last) right = chain_.judge(open_[last - 1]);
        }
    }
    open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(last), open_.end());
    open_.erase(open_.begin(), open_.begin() + static_cast<std::ptrdiff_t>(first));
}

/// Judges all open points over the whole gap. Those that fit without doubt come back together, otherwise the one
/// that is surest to lie near its prediction.
bool StretchSearch::take_from_middle() {
    verdicts_.clear();
    std::size_t best = open_.size();
    bool any = false;
    for (std::size_t k = 0; k < open_.size(); ++k) {
        verdicts_.push_back(chain_.judge(open_[k]));
        const Verdict& now = verdicts_.back();
        any = any || clear(now, open_[k]);
        if (!now.resolved || std::abs(now.ratio()) > ChainState::reject_factor) continue;
        if (best < open_.size() && farthest(now) >= farthest(verdicts_[best])) continue;
        best = k;
    }
    if (!any && best == open_.size()) return false;
    std::size_t left = 0;
    for (std::size_t k = 0; k < open_.size(); ++k) {
        if (any ? clear(verdicts_[k], open_[k]) : k == best) {
            chain_.note(open_[k], PointState::good, verdicts_[k]);
        } else {
            open_[left++] = open_[k];
        }
    }
    open_.resize(left);
    return true;
}

bool StretchSearch::clear(const Verdict& verdict, std::ptrdiff_t i) const {
    return verdict.resolved && !verdict.corner && std::abs(verdict.ratio()) < clear_factor &&
           verdict.sd_mm < clear_sd * chain_.sigma_at(i);
}

/// Where the neighbours are no witnesses the sampling does not resolve the shape: there the four-neighbour test
/// decides, less what sampling alone can cause.
Verdict StretchSearch::judge_unresolved(std::ptrdiff_t i) {
    Verdict out;
    const SplineResidual found = chain_.test(i);
    out.residual_mm = found.distance_mm;
    out.sd_mm = found.gain * chain_.sigma_at(i) + sampling_error(i) / ChainState::reject_factor;
    return out;
}

/// What the cubic of a good point's neighbours may miss by sampling alone. On a circle, steps h of angle g leave
/// h g^3 / 6; where the curvature jumps by d (edge to side) h^2 d / 16. Twice and once that.
double StretchSearch::sampling_error(std::ptrdiff_t i) {
    std::array<double, 2> step{}, curvature{};
    for (const int side : {0, 1}) {
        std::vector<double> steps, bends;
        std::ptrdiff_t before = chain_.good_beyond(i, side == 0 ? -1 : 1, 0.0), at = before;
        for (int k = 0; k < 7 && at != ChainState::none; ++k) {
            const std::ptrdiff_t next = chain_.good_beyond(at, side == 0 ? -1 : 1, 0.0);
            if (next == ChainState::none) break;
            if (at != before) {
                const Vec2 in = chain_.point(at) - chain_.point(before), out = chain_.point(next) - chain_.point(at);
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
    const std::ptrdiff_t b = chain_.good_beyond(i, -1, 0.0), c = chain_.good_beyond(i, 1, 0.0);
    if (b == ChainState::none || c == ChainState::none) return 0.0;
    const double gap = (chain_.point(c) - chain_.point(b)).norm();
    const double h = std::max({step[0], step[1], 0.5 * gap}),
                 g = std::min(1.5, 0.5 * h * std::abs(curvature[0] + curvature[1]));
    return h * g * g * g / 3.0 + h * h * std::abs(curvature[0] - curvature[1]) / 16.0;
}

/// The good points of a settled stretch once more, with their final neighbours: worst first.
void StretchSearch::verify(std::ptrdiff_t low, std::ptrdiff_t high) {
    for (std::size_t tries = 0; tries < longest_bad_run; ++tries) {
        std::ptrdiff_t worst = ChainState::none;
        Verdict found;
        for (std::ptrdiff_t i = low; i <= high; ++i) {
            if (chain_.state(i) != PointState::good || !chain_.stands_out(i)) continue;
            const Verdict verdict = chain_.judge(i);
            if (!verdict.resolved || std::abs(verdict.ratio()) <= ChainState::reject_factor) continue;
            if (worst != ChainState::none && std::abs(verdict.ratio()) <= std::abs(found.ratio())) continue;
            worst = i;
            found = verdict;
        }
        if (worst == ChainState::none) break;
        chain_.note(worst, PointState::bad, found);
    }
}

}  // namespace cmm::fitting
