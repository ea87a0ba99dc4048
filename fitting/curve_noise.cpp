// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/smoothing.hpp"

namespace cmm::fitting {

CurveNoise::CurveNoise(std::vector<double> knots, std::vector<Row> covariance,
                       std::shared_ptr<const BandSolver<4>> normal, std::vector<Row> gram, double sigma_mm)
    : knots_(std::move(knots)),
      covariance_(std::move(covariance)),
      normal_(std::move(normal)),
      gram_(std::make_shared<const std::vector<Row>>(std::move(gram))),
      point_sigma_mm_(sigma_mm) {}

std::array<double, 4> CurveNoise::Walk::functions_at(double t) {
    if (!(t >= low_ && t < high_)) {
        const auto breaks = std::span(noise_.knots_).subspan(3, noise_.controls() + 1);
        const auto above = std::upper_bound(breaks.begin() + 1, breaks.end() - 1, t);
        span_ = static_cast<std::size_t>(above - breaks.begin()) - 1;
        low_ = breaks[span_];
        high_ = breaks[span_ + 1];
        basis_ = cubic_basis(&noise_.knots_[span_ + 1]);
    }
    return basis_.at(std::clamp((t - low_) / (high_ - low_), 0.0, 1.0));
}

double CurveNoise::Walk::sigma_mm(double t) {
    const auto b = functions_at(t);
    double variance = 0.0;
    for (std::size_t a = 0; a < 4; ++a) {
        const auto& row = noise_.covariance_[noise_.wrapped(span_ + a)];
        variance += b[a] * b[a] * row[0];
        for (std::size_t c = a + 1; c < 4; ++c)
            variance += 2.0 * b[a] * b[c] * row[c - a];
    }
    return std::sqrt(std::max(variance, 0.0));
}

void CurveNoise::Walk::add_place(double t, double weight, std::span<double> slopes) {
    const auto b = functions_at(t);
    for (std::size_t a = 0; a < 4; ++a)
        slopes[noise_.wrapped(span_ + a)] += weight * b[a];
}

CurveNoise::Variance CurveNoise::variance(std::span<double> slopes) const {
    const std::vector<double> by_control(slopes.begin(), slopes.end());
    normal_->solve(slopes);
    double sum = 0.0, scatter = 0.0;
    for (std::size_t k = 0; k < slopes.size(); ++k) {
        sum += by_control[k] * slopes[k];
        const auto& gram = (*gram_)[k];
        double by_points = gram[0] * slopes[k];
        for (std::size_t m = 1; m < gram.size(); ++m)
            by_points += 2.0 * gram[m] * slopes[k >= m ? k - m : k + slopes.size() - m];
        scatter += slopes[k] * by_points;
    }
    const double square = point_sigma_mm_ * point_sigma_mm_;
    sum = std::max(sum, 0.0);
    scatter = std::clamp(scatter, 0.0, sum);
    return {square * scatter, square * (sum - scatter)};
}

void CurveNoise::covary(std::span<double> slopes) const {
    normal_->solve(slopes);
    for (double& with_control : slopes)
        with_control *= point_sigma_mm_ * point_sigma_mm_;
}

}  // namespace cmm::fitting
