// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/smoothing.hpp"

namespace cmm::fitting {

CurveNoise::CurveNoise(std::vector<double> knots, std::vector<std::array<double, 4>> covariance,
                       std::shared_ptr<const BandSolver<4>> normal, double sigma_mm)
    : knots_(std::move(knots)),
      covariance_(std::move(covariance)),
      normal_(std::move(normal)),
      point_sigma_mm_(sigma_mm) {
    bases_.reserve(controls());
    for (std::size_t span = 0; span < controls(); ++span)
        bases_.push_back(cubic_basis(&knots_[span + 1]));
}

std::size_t CurveNoise::span_of(double t) const {
    const auto breaks = std::span(knots_).subspan(3, controls() + 1);
    const auto above = std::upper_bound(breaks.begin() + 1, breaks.end() - 1, t);
    return static_cast<std::size_t>(above - breaks.begin()) - 1;
}

std::array<double, 4> CurveNoise::basis_at(std::size_t span, double t) const {
    const double low = knots_[span + 3], high = knots_[span + 4];
    return bases_[span].at(std::clamp((t - low) / (high - low), 0.0, 1.0));
}

double CurveNoise::sigma_mm(double t) const {
    const std::size_t span = span_of(t);
    const auto b = basis_at(span, t);
    double variance = 0.0;
    for (std::size_t a = 0; a < 4; ++a) {
        const auto& row = covariance_[wrapped(span + a)];
        variance += b[a] * b[a] * row[0];
        for (std::size_t c = a + 1; c < 4; ++c)
            variance += 2.0 * b[a] * b[c] * row[c - a];
    }
    return std::sqrt(std::max(variance, 0.0));
}

void CurveNoise::add_place(double t, double weight, std::span<double> slopes) const {
    const std::size_t span = span_of(t);
    const auto b = basis_at(span, t);
    for (std::size_t a = 0; a < 4; ++a)
        slopes[wrapped(span + a)] += weight * b[a];
}

double CurveNoise::variance(std::span<double> slopes) const {
    const std::vector<double> by_control(slopes.begin(), slopes.end());
    normal_->solve(slopes);
    double sum = 0.0;
    for (std::size_t k = 0; k < slopes.size(); ++k)
        sum += by_control[k] * slopes[k];
    return point_sigma_mm_ * point_sigma_mm_ * std::max(sum, 0.0);
}

}  // namespace cmm::fitting
