// SPDX-License-Identifier: Apache-2.0
#include "fitting/fairing.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "fitting/bspline_pieces.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr std::size_t most_moves_each = 50;
constexpr double least_fall = 1e-3;  // of the jumps around a knot: less is not worth a move

/// Control i weighs the basis function over the knots i ... i + 4, and belongs to the knot i + 2.
class Fairer {
  public:
    Fairer(const BSpline<2>& spline, double most) : first_(spline.controls()), now_(first_), most_(most) {
        const std::size_t n = now_.size();
        const auto& knots = spline.knots();  // three spans more at either end
        period_ = spline.back() - spline.front();
        knots_.assign(knots.begin(), knots.begin() + static_cast<std::ptrdiff_t>(n));
        settled_.assign(n, 0);
        jumps_.resize(n);
        for (std::size_t k = 0; k < n; ++k)
            jumps_[k] = jump(index(k));
    }

    double sum() const {
        double all = 0.0;
        for (const double jump : jumps_)
            all += jump;
        return all;
    }

    std::size_t run() {
        std::size_t moves = 0;
        while (moves < most_moves_each * now_.size()) {
            std::size_t worst = now_.size();
            for (std::size_t k = 0; k < now_.size(); ++k)
                if (!settled_[k] && (worst == now_.size() || jumps_[k] > jumps_[worst])) worst = k;
            if (worst == now_.size()) break;
            settled_[worst] = 1;
            if (move(index(worst))) ++moves;
        }
        return moves;
    }

    const std::vector<Vec2>& controls() const { return now_; }
    double largest() const {
        double most = 0.0;
        for (std::size_t i = 0; i < now_.size(); ++i)
            most = std::max(most, (now_[i] - first_[i]).norm());
        return most;
    }

  private:
    using Index = std::ptrdiff_t;  // of a knot or control, any lap
    static Index index(std::size_t k) { return static_cast<Index>(k); }
    std::size_t round(Index k) const {
        const auto n = static_cast<Index>(now_.size());
        return static_cast<std::size_t>(((k % n) + n) % n);
    }
    double knot(Index k) const {
        const auto n = static_cast<Index>(now_.size());
        const Index lap = k >= 0 ? k / n : -((n - 1 - k) / n);
        return knots_[static_cast<std::size_t>(k - lap * n)] + period_ * static_cast<double>(lap);
    }
    const Vec2& control(Index i) const { return now_[round(i)]; }

    /// Third derivative on the span from knot k to the next.
    Vec2 third(Index k) const {
        const auto d1 = [&](Index i) -> Vec2 { return 3.0 * (control(i) - control(i - 1)) / (knot(i + 3) - knot(i)); };
        const auto d2 = [&](Index i) -> Vec2 { return 2.0 * (d1(i) - d1(i - 1)) / (knot(i + 2) - knot(i)); };
        return (d2(k) - d2(k - 1)) / (knot(k + 1) - knot(k));
    }
    double jump(Index k) const { return (third(k) - third(k - 1)).norm(); }

    /// Where the control of knot k makes the third derivative continuous there.
    Vec2 fair_place(Index k) const {
        const auto d = [&](Index away) -> const Vec2& { return control(k - 2 + away); };
        const auto t = [&](Index away) { return knot(k + away); };
        const Vec2 left = ((t(1) - t(-3)) * d(-1) - (t(1) - t(0)) * d(-2)) / (t(0) - t(-3));
        const Vec2 right = ((t(3) - t(-1)) * d(1) - (t(0) - t(-1)) * d(2)) / (t(3) - t(0));
        return ((t(2) - t(0)) * left + (t(0) - t(-2)) * right) / (t(2) - t(-2));
    }

    bool move(Index k) {
        Vec2& place = now_[round(k - 2)];
        const Vec2& origin = first_[round(k - 2)];
        const Vec2 before = place;
        Vec2 off = fair_place(k) - origin;
        if (off.norm() > most_) off *= most_ / off.norm();
        double old_sum = 0.0, new_sum = 0.0;
        for (Index i = k - 2; i <= k + 2; ++i)
            old_sum += jumps_[round(i)];
        place = origin + off;
        for (Index i = k - 2; i <= k + 2; ++i)
            new_sum += jump(i);
        if (!(new_sum < (1.0 - least_fall) * old_sum)) {
            place = before;
            return false;
        }
        for (Index i = k - 2; i <= k + 2; ++i)
            jumps_[round(i)] = jump(i);
        for (Index i = k - 4; i <= k + 4; ++i)
            if (i != k) settled_[round(i)] = 0;
        return true;
    }

    std::vector<Vec2> first_, now_;
    std::vector<double> knots_, jumps_;
    std::vector<char> settled_;  // its move was tried since its neighbours last moved
    double period_ = 0.0, most_ = 0.0;
};

}  // namespace

core::Result<Fairing> fair_closed(const PiecewiseCubic& curve, double most_mm) {
    if (!curve.closed() || !(most_mm >= 0.0))
        return core::fail(ErrorCode::fit_not_evaluable, "fairing: needs a closed curve and a bound of 0 or more");
    auto spline = to_bspline(curve);
    if (!spline) return tl::unexpected(spline.error());
    if (spline->controls().size() != curve.spans() || curve.spans() < 8)
        return core::fail(ErrorCode::fit_not_evaluable, "fairing: needs 8 simple knots or more");
    Fairer fairer(*spline, most_mm);
    Fairing out;
    out.before = fairer.sum();
    out.moves = fairer.run();
    out.after = fairer.sum();
    out.largest_mm = fairer.largest();
    auto faired = BSpline<2>::make(3, spline->knots(), fairer.controls(), true);
    if (!faired) return tl::unexpected(faired.error());
    auto pieces = to_piecewise(*faired);
    if (!pieces) return tl::unexpected(pieces.error());
    out.curve = std::move(*pieces);
    return out;
}

}  // namespace cmm::fitting
