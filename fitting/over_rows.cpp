// SPDX-License-Identifier: Apache-2.0
#include "fitting/over_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "fitting/small_system.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr int most_smoothings = 6;
constexpr int usual_terms = 4, most_terms = 9;
constexpr int rows_per_term = 3;
/// Mean squared difference of neighbours over the mean square (von Neumann 1941): 2 of residuals that know nothing of
/// each other, some 0.4 to either side for 25 rows; 1 where only the first or the last row is off.
constexpr double least_ratio = 0.8;
constexpr double far_medians = 6.0;
constexpr double least_row_freedom = 0.05;  // of a row: 1 less its leverage

class OverRows {
  public:
    OverRows(std::span<const double> z, std::span<const std::optional<Known>> known)
        : z_(z), known_(known), use_(z.size()), spread_(z.size()), out_{Values(z.size()), Values(z.size())} {
        use_all();
        terms_ = std::min(usual_terms, terms_for_rows());
    }

    /// Of a degree that the rows bear out: a part that turns unevenly over z is no cubic.
    Smoothed run() && {
        leave_out_and_smooth();
        while (terms_ < std::min(most_terms, terms_for_rows()) && follow_each_other()) {
            use_all();
            ++terms_;
            leave_out_and_smooth();
        }
        return std::move(out_);
    }

  private:
    using Values = std::vector<double>;

    void use_all() {
        used_ = 0;
        for (std::size_t k = 0; k < z_.size(); ++k)
            used_ += static_cast<std::size_t>(use_[k] = static_cast<char>(known_[k].has_value()));
    }
    int terms_for_rows() const {
        const auto known = std::count_if(known_.begin(), known_.end(), [](const auto& row) { return row.has_value(); });
        return static_cast<int>(known) / rows_per_term + 1;
    }

    void leave_out_and_smooth() {
        for (int round = 0; round < most_smoothings; ++round) {
            // One that is sure of a wrong place would draw the others to it before it is found.
            all_alike_ = round == 0;
            smooth();
            if (!leave_out_far() && !all_alike_) break;
        }
    }

    /// What is left of neighbours is alike: the polynomial misses the form, most at the ends, which it leaves out then.
    bool follow_each_other() const {
        double differences = 0.0, squares = 0.0;
        std::optional<double> before;
        for (std::size_t k = 0; k < z_.size(); ++k) {
            if (!known_[k]) continue;
            const double left = off(k) / sigma(k);
            if (before) differences += (left - *before) * (left - *before);
            squares += left * left;
            before = left;
        }
        return differences < least_ratio * squares;
    }

    double sigma(std::size_t k) const { return all_alike_ ? 1.0 : known_[k]->sigma; }
    double off(std::size_t k) const { return known_[k]->value - out_.value[k]; }

    SmallVector powers(std::size_t k) const {
        const double middle = 0.5 * (z_.front() + z_.back()), half = std::max(0.5 * (z_.back() - z_.front()), 1e-12);
        SmallVector p(terms_);
        p[0] = 1.0;
        for (int i = 1; i < terms_; ++i)
            p[i] = p[i - 1] * (z_[k] - middle) / half;
        return p;
    }

    void smooth() {
        SmallMatrix normal = SmallMatrix::Zero(terms_, terms_);
        SmallVector rhs = SmallVector::Zero(terms_);
        double weights = 0.0, weight_squares = 0.0;
        for (std::size_t k = 0; k < z_.size(); ++k) {
            if (use_[k] == 0) continue;
            const SmallVector p = powers(k);
            const double weight = 1.0 / (sigma(k) * sigma(k));
            weights += weight;
            weight_squares += weight * weight;
            normal += weight * p * p.transpose();
            rhs += weight * known_[k]->value * p;
        }
        const SmallVector solution = solve_small(normal, rhs);
        squares_ = 0.0;
        for (std::size_t k = 0; k < z_.size(); ++k) {
            const SmallVector p = powers(k);
            out_.value[k] = solution.dot(p);
            spread_[k] = p.dot(solve_small(normal, p));
            if (use_[k] != 0) squares_ += std::pow(off(k) / sigma(k), 2);
        }
        free_ = std::max(static_cast<double>(used_) - terms_, 1.0);
        out_.apart = std::sqrt(std::max(squares_ - free_, 0.0) / (weights - weight_squares / weights));
        for (std::size_t k = 0; k < z_.size(); ++k)
            out_.sigma[k] = std::sqrt(squares_ / free_ * spread_[k]);
    }

    /// Off what the others say (deleted residuals: Belsley, Kuh, Welsch 1980), by what they and the row know.
    double sigmas_off(std::size_t k) const {
        const double leverage = spread_[k] / (sigma(k) * sigma(k)),
                     freedom = std::max(1.0 - leverage, least_row_freedom);
        const double squares = std::max(squares_ - std::pow(off(k) / sigma(k), 2) / freedom, 0.0);
        const double of_others = std::sqrt(squares / std::max(free_ - 1.0, 1.0) * spread_[k] / freedom);
        return std::abs(off(k)) / freedom / std::hypot(known_[k]->sigma, of_others);
    }

    bool leave_out_far() {
        if (used_ < 2 * static_cast<std::size_t>(terms_)) return false;
        Values all;
        for (std::size_t k = 0; k < z_.size(); ++k)
            if (use_[k] != 0) all.push_back(sigmas_off(k));
        const double far = far_medians * nth_smallest(all, all.size() / 2);
        const std::size_t before = used_;
        for (std::size_t k = 0; k < z_.size(); ++k) {
            if (use_[k] == 0 || sigmas_off(k) <= far) continue;
            use_[k] = 0;
            --used_;
        }
        return used_ < before;
    }

    std::span<const double> z_;
    std::span<const std::optional<Known>> known_;
    std::vector<char> use_;
    std::size_t used_ = 0;
    int terms_ = 1;  // of the polynomial
    bool all_alike_ = true;
    Values spread_;  // of the polynomial at z_k: its variance, if one of sigma 1 has variance 1
    double squares_ = 0.0, free_ = 1.0;
    Smoothed out_;
};

}  // namespace

Smoothed smoothed_over(std::span<const double> z, std::span<const std::optional<Known>> known) {
    return OverRows(z, known).run();
}

}  // namespace cmm::fitting
