// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace cmm::fitting {

/// The mean curvature of an outline that is a formula, at(t) with t in [0, 4) and continuous parts between whole
/// numbers: the weights (1 - u^2)^2 summed over 20 000 stretches; nothing of the library's.
class TrueCurvature {
  public:
    template <typename Outline>
    explicit TrueCurvature(const Outline& at) {
        for (std::size_t k = 0; k < count; ++k) {
            const auto jet = at(4.0 * (static_cast<double>(k) + 0.5) / count);
            from_.push_back(perimeter_);
            curvature_.push_back(jet.curvature());
            perimeter_ += jet.d1.norm() * 4.0 / count;
        }
        from_.push_back(perimeter_);
    }
    double perimeter() const { return perimeter_; }
    double arc_of(double t) const {
        const double place = t / 4.0 * count;
        const auto k = std::min(static_cast<std::size_t>(place), count - 1);
        return from_[k] + (place - static_cast<double>(k)) * (from_[k + 1] - from_[k]);
    }
    double mean(double s, double window) const {
        const double half = 0.5 * window, in = std::fmod(s - half, perimeter_);
        const double start = in < 0.0 ? in + perimeter_ : in;
        auto k = static_cast<std::size_t>(std::upper_bound(from_.begin(), from_.end(), start) - from_.begin()) - 1;
        double weighted = 0.0, weights = 0.0;
        for (double way = from_[k] - start - half; way < half; ++k) {
            k %= count;
            const double length = from_[k + 1] - from_[k], u = (way + 0.5 * length) / half;
            const double weight = std::abs(u) < 1.0 ? (1 - u * u) * (1 - u * u) * length : 0.0;
            weighted += weight * curvature_[k];
            weights += weight;
            way += length;
        }
        return weighted / weights;
    }

  private:
    static constexpr std::size_t count = 20000;
    std::vector<double> from_, curvature_;
    double perimeter_ = 0.0;
};

}  // namespace cmm::fitting
