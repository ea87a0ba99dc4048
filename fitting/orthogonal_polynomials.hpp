// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace cmm::fitting {

/// Polynomials that are orthogonal on some places, one degree after the other, by Forsythe's recurrence (1957)
/// P_{j+1} = (x - a_j) P_j - b_j P_{j-1}; the places are brought to [-1, 1].
template <std::size_t MostPlaces, std::size_t MostDegree>
class OrthogonalPolynomials {
  public:
    /// Degree 0. One place or more.
    void begin(std::span<const double> places) {
        count_ = places.size();
        const auto [low, high] = std::minmax_element(places.begin(), places.end());
        middle_ = 0.5 * (*low + *high);
        half_ = std::max(0.5 * (*high - *low), 1e-12);
        const double scale = 1.0 / half_;
        for (std::size_t i = 0; i < count_; ++i) {
            x_[i] = (places[i] - middle_) * scale;
            now_[i] = 1.0;
            before_[i] = 0.0;
        }
        norm_[0] = static_cast<double>(count_);
        degree_ = 0;
    }

    /// The next degree, at most MostDegree. False where the places do not tell it from those below: nothing is changed.
    bool raise() {
        double centre = 0.0;
        for (std::size_t i = 0; i < count_; ++i)
            centre += x_[i] * now_[i] * now_[i];
        const double a = a_[degree_] = centre / norm_[degree_];
        const double b = b_[degree_] = degree_ > 0 ? norm_[degree_] / norm_[degree_ - 1] : 0.0;
        double norm = 0.0;
        for (std::size_t i = 0; i < count_; ++i) {
            const double next = (x_[i] - a) * now_[i] - b * before_[i];
            before_[i] = now_[i];
            now_[i] = next;
            norm += next * next;
        }
        if (!(norm > 1e-20)) return false;
        norm_[++degree_] = norm;
        return true;
    }

    std::size_t degree() const { return degree_; }
    /// Of the highest degree, at the places; its sum of squares.
    const std::array<double, MostPlaces>& values() const { return now_; }
    double norm() const { return norm_[degree_]; }
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
    std::array<double, MostPlaces> x_{}, now_{}, before_{};
    std::array<double, MostDegree + 1> a_{}, b_{}, norm_{};
    std::size_t count_ = 0, degree_ = 0;
    double middle_ = 0.0, half_ = 1.0;
};

}  // namespace cmm::fitting
