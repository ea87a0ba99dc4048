// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "fitting/chain_state.hpp"
#include "fitting/circle_frame.hpp"
#include "fitting/orthogonal_polynomials.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {

/// Neighbouring points of a chain that may all be bad.
struct PointRun {
    static constexpr auto longest = static_cast<std::ptrdiff_t>(longest_bad_run);
    using Values = Eigen::Array<double, longest, 1>;  ///< one of each of its points

    std::ptrdiff_t first = 0, length = 0;
};

/// Points to one side of a run that are not heard: so many next to it, and those of another run by their distances.
struct LeftOut {
    std::ptrdiff_t next = 0, from = 0, to = 0;
    bool has(std::ptrdiff_t distance) const { return distance < next || (distance >= from && distance < to); }
};

struct Flanks {
    static constexpr std::ptrdiff_t most_points = 12;
    static constexpr std::ptrdiff_t farthest = 24;  ///< from the run: of the points that may be heard
    static constexpr std::size_t highest_degree = 6;

    std::ptrdiff_t points;  ///< a side
    std::size_t most_degree;
    LeftOut before{}, after{};
};

/// A run among good points to either side of it, in the frame of these: whether a polynomial through all explains them,
/// or one with the run lifted off it (Bayesian information criterion, Schwarz 1978). `Lanes`: room for both flanks and
/// the run, a multiple of four so that vector lanes hold all; those that are left over count for nothing.
template <int Lanes>
class RunAmongOthers {
  public:
    static constexpr double gain_of_bad_run = 18.0;  // of the criterion: a probability of 8 000 to one

    RunAmongOthers(ChainState& chain, const PointRun& run, const Flanks& flanks, double sigma_mm)
        : flanks_(flanks), side_(flanks.points), length_(run.length), sigma_(sigma_mm) {
        std::array<Vec2, Flanks::most_points> before, after;
        const std::ptrdiff_t low = collect(chain, run.first - 1, -1, flanks.before, before);
        const std::ptrdiff_t high = collect(chain, run.first + run.length, 1, flanks.after, after);
        if (low == ChainState::none || high == ChainState::none || high - low >= chain.size()) return;
        const auto last = static_cast<std::size_t>(side_ - 1);
        const CircleFrame frame(before[last], before[0], after[last]);
        count_ = 2 * side_ + length_;
        for (std::ptrdiff_t k = 0; k < side_; ++k) {
            place(side_ - 1 - k, before[static_cast<std::size_t>(k)]);
            place(side_ + length_ + k, after[static_cast<std::size_t>(k)]);
        }
        for (std::ptrdiff_t k = 0; k < length_; ++k)
            place(side_ + k, chain.point(run.first + k));
        for (std::ptrdiff_t k = count_; k < Lanes; ++k)
            place(k, after[last]);
        frame.bring(x_, y_);
        there_.setZero();
        there_.head(count_) = 1.0;
        y_ *= there_;
        price_ = std::log(static_cast<double>(count_));
        if (!frame.is_far(x_.abs().maxCoeff())) compare();
    }

    /// Of the run off the others, where a polynomial through these leaves residuals like noise; otherwise 0.
    double lift_mm() const { return lift_; }
    /// Of the lift and of a point: the larger.
    double sd_mm() const { return sd_; }
    /// Of each point of the run off that polynomial.
    const PointRun::Values& off_mm() const { return off_; }
    /// Of the criterion, against the best curve without a lift.
    double gain() const { return lift_ != 0.0 ? plain_ - lifted_ : 0.0; }
    /// No lift explains so much better than the best curve without one.
    bool is_plain() const { return plain_ <= most_of_plain(); }
    /// Were the standard deviation of a point smaller than this, it might not be plain.
    double plain_sigma_mm() const { return sigma_ * std::sqrt(plain_ / most_of_plain()); }

    /// The best curve without a lift may also be one whose curvature jumps near the run.
    void allow_jumps() {
        for (std::ptrdiff_t gap = side_ - 2; gap < side_ + length_ + 2; ++gap)
            for (const double share : {0.0, 0.5})
                allow_jump(x_[gap] + share * (x_[gap + 1] - x_[gap]));
    }

  private:
    static constexpr double fewest_numbers = 3;  // of a polynomial with a lift
    static constexpr double least_unexplained = 1e-6;
    using Values = Eigen::Array<double, Lanes, 1>;
    using Terms = OrthogonalPolynomials<Values, Flanks::highest_degree>;

    /// The last point of the flank; none where there are not enough.
    std::ptrdiff_t collect(ChainState& chain, std::ptrdiff_t from, std::ptrdiff_t step, const LeftOut& left_out,
                           std::array<Vec2, Flanks::most_points>& points) const {
        std::ptrdiff_t count = 0;
        for (std::ptrdiff_t at = from; std::abs(at - from) < Flanks::farthest && chain.exists(at); at += step) {
            if (chain.state(at) == PointState::bad || left_out.has(std::abs(at - from))) continue;
            points[static_cast<std::size_t>(count++)] = chain.point(at);
            if (count == side_) return at;
        }
        return ChainState::none;
    }

    void place(std::ptrdiff_t k, const Vec2& p) {
        x_[k] = p.x();
        y_[k] = p.y();
    }

    /// Polynomials without the lift, and the simplest one that holds with it.
    void compare() {
        const double variance = sigma_ * sigma_;
        const bool with_next = !flanks_.before.has(0) && !flanks_.after.has(0);
        Values run = Values::Zero();  // what no polynomial has of the lift
        run.segment(side_, length_) = 1.0;
        std::size_t of_run = 0;  // degrees that are taken off it
        terms_.begin(x_, there_);
        do {
            const std::size_t degree = terms_.degree();
            take_off(degree, y_);
            left_[degree] = y_;
            const double squares = y_.square().sum();
            squares_[degree] = squares;
            if (degree == 0) continue;
            plain_ = std::min(plain_, squares / variance + price(degree + 1));
            if (with_next && is_plain()) return;
            if (lift_ != 0.0) continue;
            while (of_run <= degree)
                take_off(of_run++, run);
            const double unexplained = run.square().sum(), along = (run * y_).sum();
            if (unexplained < least_unexplained) continue;
            const double with = squares - along * along / unexplained;
            if (with > variance * chi_square_limit_999(static_cast<std::size_t>(count_) - degree - 2)) continue;
            lifted_ = with / variance + price(degree + 2);
            lift_ = along / unexplained;
            sd_ = sigma_ * std::max(1.0, 1.0 / std::sqrt(unexplained));
            off_.head(length_) = y_.segment(side_, length_) + lift_ * (1.0 - run.segment(side_, length_));
        } while (terms_.degree() < flanks_.most_degree && terms_.raise());
    }

    void allow_jump(double at) {
        Values jump = there_ * (x_ - at).max(0.0).square();
        for (std::size_t degree = 0; degree <= terms_.degree(); ++degree) {
            take_off(degree, jump);
            const double unexplained = jump.square().sum(), along = (jump * left_[degree]).sum();
            if (degree == 0 || !(unexplained > 0.0)) continue;
            plain_ = std::min(plain_,
                              (squares_[degree] - along * along / unexplained) / (sigma_ * sigma_) + price(degree + 3));
        }
    }

    double price(std::size_t numbers) const { return static_cast<double>(numbers) * price_; }
    double most_of_plain() const { return gain_of_bad_run + fewest_numbers * price_; }
    void take_off(std::size_t degree, Values& from) const {
        const Values& term = terms_.values_of(degree);
        from -= (term * from).sum() / terms_.norm_of(degree) * term;
    }

    Flanks flanks_;
    std::ptrdiff_t side_, length_, count_ = 0;
    double sigma_, plain_ = HUGE_VAL, lifted_ = HUGE_VAL, lift_ = 0.0, sd_ = 0.0;
    double price_ = 0.0;    // of a number, by the criterion
    Values x_, y_, there_;  // there_: 1 where there is a point, otherwise 0
    Terms terms_;
    std::array<Values, Flanks::highest_degree + 1> left_;  // by the polynomials up to each degree, of y
    std::array<double, Flanks::highest_degree + 1> squares_{};
    PointRun::Values off_ = PointRun::Values::Zero();
};

}  // namespace cmm::fitting
