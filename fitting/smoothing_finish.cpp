// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <utility>

#include "fitting/smoothing_system.hpp"

namespace cmm::fitting {

SmoothCurve SmoothingSystem::finish(std::vector<CurvatureStep> joints, std::span<const std::size_t> order,
                                    const Vec2& origin, double doubt) && {
    const auto n = static_cast<std::size_t>(measured_);
    SmoothCurve out;
    out.parameter.resize(n);
    out.residual.resize(n);
    out.leverage.resize(n);
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (order[i] == supposed) continue;
        out.parameter[order[i]] = t_[i];
        out.residual[order[i]] = residual_[i];
        out.leverage[order[i]] = leverage(i);
    }
    out.sigma_mm = sigma_;
    out.freedom = freedom_;
    out.joints = std::move(joints);
    auto pieces = curve_.pieces();
    for (auto& piece : pieces)
        piece[0] += origin;
    out.curve = PiecewiseCubic(breaks_, std::move(pieces), true);
    out.noise = std::move(*this).noise(doubt);
    return out;
}

CurveNoise SmoothingSystem::noise(double doubt) && {
    if (solve(doubt)) normal_.invert(inverse_);
    std::vector<CurveNoise::Row> covariance(spans_), gram(spans_);
    for (std::size_t k = 0; k < spans_; ++k) {
        for (std::size_t m = 0; m < 4; ++m) {
            covariance[k][m] = static_cast<float>(sigma_ * sigma_ * inverse_[k][m]);
            gram[k][m] = static_cast<float>(gram_[k][m]);
        }
    }
    normal_.forget_inverse();
    const auto knots = least_squares_.knots();
    return CurveNoise({knots.begin(), knots.end()}, std::move(covariance),
                      std::make_shared<const BandSolver<4>>(std::move(normal_)), std::move(gram), sigma_);
}

}  // namespace cmm::fitting
