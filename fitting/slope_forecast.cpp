// SPDX-License-Identifier: Apache-2.0
#include "fitting/slope_forecast.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmm::fitting {
namespace {

constexpr double less_from_one_side = 2.0;  // so much less is a slope known where all others lie above, or below

}  // namespace

SlopeForecast::SlopeForecast(std::span<const double> heights_mm) {
    for (std::size_t k = 0; k < heights_mm.size(); ++k) {
        weight_[k] = 1.0;
        for (std::size_t other = 0; other < heights_mm.size(); ++other)
            if (other != k) weight_[k] *= heights_mm[other] / (heights_mm[other] - heights_mm[k]);
    }
    if (heights_mm.size() < 2) return;
    const auto [lowest, highest] = std::minmax_element(heights_mm.begin(), heights_mm.end());
    step_mm_ = std::numeric_limits<double>::infinity();
    for (const double height : heights_mm)
        step_mm_ = std::min(step_mm_, std::abs(height));
    if (*lowest > 0.0 || *highest < 0.0) step_mm_ /= less_from_one_side;
}

double SlopeForecast::slope_error(double missed_mm) const {
    return step_mm_ > 0.0 ? std::abs(missed_mm) / step_mm_ : std::numeric_limits<double>::infinity();
}

}  // namespace cmm::fitting
