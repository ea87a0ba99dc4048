// SPDX-License-Identifier: Apache-2.0
#include "fitting/swapped_runs.hpp"

#include <cmath>
#include <vector>

#include "fitting/bridge.hpp"

namespace cmm::fitting {
namespace {

constexpr std::ptrdiff_t most_between = 3;
constexpr double good_sigmas = 3.0, bad_sigmas = 5.0;

class PlaceExchange {
  public:
    PlaceExchange(std::span<const Vec2> points, bool closed, BadPoints& found)
        : points_(points), closed_(closed), found_(found), n_(static_cast<std::ptrdiff_t>(points.size())) {}

    void run() {
        for (std::ptrdiff_t before = 0; before < n_; ++before) {
            if (!bad(before)) continue;
            std::ptrdiff_t after = before + 1;
            while (after - before <= most_between + 1 && inside(after) && !bad(after))
                ++after;
            const std::ptrdiff_t between = after - before - 1;
            if (between < 1 || between > most_between || !inside(after) || !bad(after)) continue;
            if (residual(before) * residual(after) > 0.0) exchange(before, after);
        }
    }

  private:
    std::size_t at(std::ptrdiff_t i) const { return static_cast<std::size_t>((i % n_ + n_) % n_); }
    bool inside(std::ptrdiff_t i) const { return closed_ || (i >= 0 && i < n_); }
    bool bad(std::ptrdiff_t i) const { return found_.bad[at(i)] != 0; }
    double residual(std::ptrdiff_t i) const { return found_.residual[at(i)]; }

    /// What the points beyond the two, and the two themselves, foretell of the point i.
    Verdict judge(std::ptrdiff_t i, std::ptrdiff_t before, std::ptrdiff_t after) const {
        Neighbours near;
        const auto gather = [&](std::ptrdiff_t from, std::ptrdiff_t by, auto& points, std::size_t& count) {
            for (std::ptrdiff_t k = from; count < Neighbours::most && std::abs(k - from) < reach && inside(k); k += by)
                if (k != i && (k == before || k == after || !bad(k))) points[count++] = points_[at(k)];
        };
        gather(before, -1, near.before, near.count_before);
        gather(after, 1, near.after, near.count_after);
        return judge_point(near, points_[at(i)], found_.sigma_mm);
    }

    void exchange(std::ptrdiff_t before, std::ptrdiff_t after) {
        std::vector<Verdict> verdicts;
        for (std::ptrdiff_t i = before; i <= after; ++i) {
            const Verdict verdict = judge(i, before, after);
            const bool flank = i == before || i == after;
            const bool as_told =
                flank ? std::abs(verdict.ratio()) < good_sigmas : std::abs(verdict.ratio()) > bad_sigmas;
            if (!verdict.resolved || verdict.corner || !as_told) return;
            verdicts.push_back(verdict);
        }
        for (std::ptrdiff_t i = before; i <= after; ++i) {
            const Verdict& verdict = verdicts[static_cast<std::size_t>(i - before)];
            const bool flank = i == before || i == after;
            found_.bad[at(i)] = flank ? 0 : 1;
            found_.residual[at(i)] = verdict.residual_mm;
            found_.threshold_mm[at(i)] = bad_sigmas * verdict.sd_mm;
            found_.count = flank ? found_.count - 1 : found_.count + 1;
        }
    }

    static constexpr std::ptrdiff_t reach = 12;

    std::span<const Vec2> points_;
    bool closed_;
    BadPoints& found_;
    std::ptrdiff_t n_;
};

}  // namespace

void exchange_swapped_runs(std::span<const Vec2> points, bool closed, BadPoints& found) {
    PlaceExchange(points, closed, found).run();
}

}  // namespace cmm::fitting
