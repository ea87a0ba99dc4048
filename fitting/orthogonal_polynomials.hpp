// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>

namespace cmm::fitting {

/// Polynomials that are orthogonal on some places, one degree after the other, by Forsythe's recurrence (1957)
/// P_{j+1} = (x - a_j) P_j - b_j P_{j-1}; the places are brought to [-1, 1].
/// `Values`: an Eigen array with a number of each place.
template <class Values, std::size_t MostDegree>
class OrthogonalPolynomials {
  public:
    /// Degree 0. `root_weights`: the root of what each place counts, 0 of those that count for nothing; one or more
    /// that do. The polynomials at the places, and what they are multiplied with, are times that root.
    void begin(const Values& places, const Values& root_weights) {
        const double low = places.minCoeff(), high = places.maxCoeff();
        middle_ = 0.5 * (low + high);
        half_ = std::max(0.5 * (high - low), 1e-12);
        x_ = (places - middle_) * (1.0 / half_);
        values_[0] = root_weights;
        norm_[0] = root_weights.square().sum();
        degree_ = 0;
    }

    /// The next degree, at most MostDegree. False where the places do not tell it from those below.
    bool raise() {
        const Values& now = values_[degree_];
        Values& next = values_[degree_ + 1];
        const double a = a_[degree_] = (x_ * now.square()).sum() / norm_[degree_];
        next = (x_ - a) * now;
        if (degree_ > 0) {
            b_[degree_] = norm_[degree_] / norm_[degree_ - 1];
            next -= b_[degree_] * values_[degree_ - 1];
        }
        const double norm = next.square().sum();
        if (!(norm > 1e-20)) return false;
        norm_[++degree_] = norm;
        return true;
    }

    std::size_t degree() const { return degree_; }
    /// At the places, and its sum of squares there; up to the highest degree.
    const Values& values_of(std::size_t degree) const { return values_[degree]; }
    double norm_of(std::size_t degree) const { return norm_[degree]; }

    /// Calls take(degree, value) for those up to `highest`, at any place.
    template <class Take>
    void at(double place, std::size_t highest, const Take& take) const {
        const double x = (place - middle_) / half_;
        double now = 1.0, before = 0.0;
        for (std::size_t j = 0; j <= highest; ++j) {
            if (j > 0) {
                const double next = (x - a_[j - 1]) * now - b_[j - 1] * before;
                before = now;
                now = next;
            }
            take(j, now);
        }
    }

  private:
    Values x_;
    std::array<Values, MostDegree + 1> values_;
    std::array<double, MostDegree + 1> a_{}, b_{}, norm_{};
    std::size_t degree_ = 0;
    double middle_ = 0.0, half_ = 1.0;
};

}  // namespace cmm::fitting
