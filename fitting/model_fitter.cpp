// SPDX-License-Identifier: Apache-2.0
#include "fitting/model_fitter.hpp"

#include <algorithm>

namespace cmm::fitting {
namespace {

// A window goes on along a side where its last so many radians take more than that share of the way from the nose: of
// a parabola, seen up to 75 degrees, they take 0.43, of an ellipse of four to one 0.32.
constexpr double side_turn_rad = 0.1;
constexpr double side_share = 0.6;
constexpr double numbers_of_a_joint = 1.5;  // that are the edge's
constexpr double rounding_floor_mm = 1e-5;  // noise-free points are not known to better than the solvers' rounding

}  // namespace

ModelFitter::ModelFitter(const EdgePoints& edge)
    : edge_(edge),
      sigma_(std::max(edge.noise.sigma_mm, rounding_floor_mm)),
      price_(std::log(static_cast<double>(std::max<std::size_t>(edge.points.size(), 2)))),
      normals_(edge.points.size()),
      residuals_(edge.points.size(), 0.0) {
    centres_.reserve(edge.points.size());
    for (const EdgePoint& p : edge.points)
        centres_.push_back(p.centre);
    forget_normals();
    data_ = {centres_, normals_, residuals_, edge.ball_mm};
}

void ModelFitter::forget_normals() {
    for (std::size_t i = 0; i < normals_.size(); ++i)
        normals_[i] = edge_.points[i].normal;
}

EdgeWindow ModelFitter::turning_by(double angle_rad) const {
    const Vec2 nose = edge_.points[edge_.nose].normal;
    const double least = std::cos(angle_rad);
    const auto within = [&](std::size_t i) { return nose.dot(edge_.points[i].normal) >= least; };
    EdgeWindow w{edge_.nose, edge_.nose + 1};
    while (w.begin > 0 && within(w.begin - 1))
        --w.begin;
    while (w.end < edge_.points.size() && within(w.end))
        ++w.end;
    return w;
}

bool ModelFitter::reaches_a_side(const EdgeWindow& w) const {
    const auto along_side = [&](std::size_t end, int inwards) {
        const Vec2& last = edge_.points[end].normal;
        double way = 0.0, hardly_turning = 0.0;
        for (std::size_t i = end; i != edge_.nose; i += inwards) {
            way += (centres_[i + inwards] - centres_[i]).norm();
            if (last.dot(edge_.points[i + inwards].normal) >= std::cos(side_turn_rad)) hardly_turning = way;
        }
        return hardly_turning > side_share * way;
    };
    return along_side(w.begin, 1) || along_side(w.end - 1, -1);
}

double ModelFitter::gain(double squares, int parameters, const EdgeWindow& w) const {
    double sum = -squares / (sigma_ * sigma_) - parameters * price_;
    sum += numbers_of_a_joint * static_cast<double>(edge_.joints) * price_;
    for (std::size_t i = w.begin; i < w.end; ++i)
        sum += free_price(i);
    return sum;
}

bool ModelFitter::within_noise(double squares, double freedom) const {
    if (!(edge_.noise.freedom > 0.0)) return true;
    const Noise floored{sigma_, edge_.noise.freedom};
    return combined_noise(squares, freedom, floored).freedom != freedom;
}

bool ModelFitter::follow_each_other(const EdgeWindow& w) const {
    double products = 0.0, squares = 0.0;
    for (std::size_t i = w.begin; i < w.end; ++i) {
        squares += residuals_[i] * residuals_[i];
        if (i > w.begin) products += residuals_[i - 1] * residuals_[i];
    }
    const double n = static_cast<double>(w.count());
    return products > 3.0 * squares / std::sqrt(n) && squares > n * rounding_floor_mm * rounding_floor_mm;
}

}  // namespace cmm::fitting
