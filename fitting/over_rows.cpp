// SPDX-License-Identifier: Apache-2.0
#include "fitting/over_rows.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "fitting/orthogonal_polynomials.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr int most_smoothings = 6;
constexpr std::size_t usual_terms = 4, most_terms = 9, rows_per_term = 3;
constexpr std::size_t sure_terms = 2;  // of a straight line: the others count as far as the rows tell them
/// Mean squared difference of neighbours over the mean square (von Neumann 1941): 2 of residuals that know nothing of
/// each other, some 0.4 to either side for 25 rows.
constexpr double least_ratio = 1.2;
constexpr double alone_factor = 3.0;  // by which one is farther off than its neighbours where that tells of no form
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
    Smoothed as_fitted() && {
        fit();
        return std::move(out_);
    }
    Smoothed as_told() && {
        fit();
        if (terms_ <= usual_terms) keep_what_is_told();
        return std::move(out_);
    }

  private:
    using Values = std::vector<double>;

    void fit() {
        leave_out_and_smooth();
        while (terms_ < std::min(most_terms, terms_for_rows()) && follow_each_other()) {
            use_all();
            ++terms_;
            leave_out_and_smooth();
        }
    }

    void use_all() {
        used_ = 0;
        for (std::size_t k = 0; k < z_.size(); ++k)
            used_ += static_cast<std::size_t>(use_[k] = static_cast<char>(known_[k].has_value()));
    }
    std::size_t terms_for_rows() const {
        const auto known = std::count_if(known_.begin(), known_.end(), [](const auto& row) { return row.has_value(); });
        return static_cast<std::size_t>(known) / rows_per_term + 1;
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
        Values left;
        for (std::size_t k = 0; k < z_.size(); ++k)
            if (known_[k]) left.push_back(off(k) / sigma(k));
        const auto size_at = [&](std::size_t i) { return i < left.size() ? std::abs(left[i]) : 0.0; };
        double differences = 0.0, squares = 0.0, before = 0.0;
        for (std::size_t i = 0; i < left.size(); ++i) {
            const double most = alone_factor * std::max(size_at(i + 1), i > 0 ? size_at(i - 1) : 0.0);
            const double now = std::clamp(left[i], -most, most);
            if (i > 0) differences += (now - before) * (now - before);
            squares += now * now;
            before = now;
        }
        return differences < least_ratio * squares;
    }

    double sigma(std::size_t k) const { return all_alike_ ? 1.0 : known_[k]->sigma; }
    double off(std::size_t k) const { return known_[k]->value - out_.value[k]; }

    void smooth() {
        const auto n = static_cast<Eigen::Index>(z_.size());
        Eigen::ArrayXd root_weights = Eigen::ArrayXd::Zero(n), weighed = Eigen::ArrayXd::Zero(n);
        double weights = 0.0, weight_squares = 0.0;
        for (std::size_t k = 0; k < z_.size(); ++k) {
            if (use_[k] == 0) continue;
            const double weight = 1.0 / (sigma(k) * sigma(k));
            weights += weight;
            weight_squares += weight * weight;
            root_weights[static_cast<Eigen::Index>(k)] = 1.0 / sigma(k);
            weighed[static_cast<Eigen::Index>(k)] = known_[k]->value / sigma(k);
        }
        polynomials_.begin(Eigen::Map<const Eigen::ArrayXd>(z_.data(), n), root_weights);
        while (polynomials_.degree() + 1 < terms_ && polynomials_.raise()) {
        }
        coefficients_.clear();
        for (std::size_t j = 0; j <= polynomials_.degree(); ++j)
            coefficients_.push_back((polynomials_.values_of(j) * weighed).sum() / polynomials_.norm_of(j));
        evaluate();
        squares_ = 0.0;
        for (std::size_t k = 0; k < z_.size(); ++k)
            if (use_[k] != 0) squares_ += std::pow(off(k) / sigma(k), 2);
        free_ = std::max(static_cast<double>(used_) - static_cast<double>(terms_), 1.0);
        out_.apart = std::sqrt(std::max(squares_ - free_, 0.0) / (weights - weight_squares / weights));
        for (std::size_t k = 0; k < z_.size(); ++k)
            out_.sigma[k] = std::sqrt(squares_ / free_ * spread_[k]);
    }
    void evaluate() {
        for (std::size_t k = 0; k < z_.size(); ++k) {
            out_.value[k] = spread_[k] = 0.0;
            polynomials_.at(z_[k], polynomials_.degree(), [&](std::size_t j, double value) {
                out_.value[k] += coefficients_[j] * value;
                spread_[k] += value * value / polynomials_.norm_of(j);
            });
        }
    }

    /// The bend of what hardly bends is noise, most of it at the ends: each coefficient by 1 - 1/t^2, t over its
    /// standard deviation (James and Stein 1961, the positive part).
    void keep_what_is_told() {
        const double variance = squares_ / free_;
        for (std::size_t j = sure_terms; j < coefficients_.size(); ++j) {
            const double square = coefficients_[j] * coefficients_[j] * polynomials_.norm_of(j);
            coefficients_[j] *= square > variance ? 1.0 - variance / square : 0.0;
        }
        evaluate();
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
        if (used_ < 2 * terms_) return false;
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
    std::size_t terms_ = 1;  // of the polynomial
    OrthogonalPolynomials<Eigen::ArrayXd, most_terms - 1> polynomials_;
    Values coefficients_;
    bool all_alike_ = true;
    Values spread_;  // of the polynomial at z_k: its variance, if one of sigma 1 has variance 1
    double squares_ = 0.0, free_ = 1.0;
    Smoothed out_;
};

}  // namespace

Smoothed smoothed_over(std::span<const double> z, std::span<const std::optional<Known>> known) {
    return OverRows(z, known).as_fitted();
}

Smoothed told_over(std::span<const double> z, std::span<const std::optional<Known>> known) {
    return OverRows(z, known).as_told();
}

}  // namespace cmm::fitting
