// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "fitting/closed_curve.hpp"

/// Closed curves for the tests of parallel curves, and the distance to them.
namespace cmm::fitting::truth {

/// The periodic spline through shape(2 pi i / count).
template <class Shape>
PiecewiseCubic through(const Shape& shape, int count) {
    std::vector<Vec2> points;
    for (int i = 0; i < count; ++i)
        points.push_back(shape(2.0 * std::numbers::pi * i / count));
    return ClosedCurve::through(points).value().spline();
}

inline PiecewiseCubic ellipse(double a, double b, int count = 3000) {
    return through([&](double t) { return Vec2(a * std::cos(t), b * std::sin(t)); }, count);
}

inline PiecewiseCubic polygon(const std::vector<Vec2>& corners) {
    std::vector<PiecewiseCubic::Piece> pieces;
    std::vector<double> breaks{0.0};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec2 side = corners[(i + 1) % corners.size()] - corners[i];
        pieces.push_back({corners[i], side.normalized(), Vec2::Zero(), Vec2::Zero()});
        breaks.push_back(breaks.back() + side.norm());
    }
    return {breaks, pieces, true};
}

/// By dense sampling and golden sections: independent of the closest point of the product.
class Distance {
  public:
    explicit Distance(const PiecewiseCubic& source) : source_(source) {
        for (int i = 0; i < 6000; ++i)
            points_.push_back(source.jet(source.period() * i / 6000.0).position);
    }
    double of(const Vec2& p) const {
        double best = 1e300;
        for (const Vec2& q : points_)
            best = std::min(best, (q - p).squaredNorm());
        const double step = source_.period() / 6000.0, near = std::pow(std::sqrt(best) + step, 2);
        double distance = std::sqrt(best);
        for (std::size_t i = 0; i < points_.size(); ++i) {
            const double here = (points_[i] - p).squaredNorm();
            if (here > near || here > (points_[(i + 1) % 6000] - p).squaredNorm() ||
                here > (points_[(i + 5999) % 6000] - p).squaredNorm())
                continue;
            double low = step * (static_cast<double>(i) - 1.0), high = low + 2.0 * step;
            const auto at = [&](double t) { return (source_.jet(t).position - p).norm(); };
            for (int k = 0; k < 60; ++k) {
                const double a = low + 0.382 * (high - low), b = low + 0.618 * (high - low);
                (at(a) < at(b) ? high : low) = at(a) < at(b) ? b : a;
            }
            distance = std::min(distance, at(0.5 * (low + high)));
        }
        return distance;
    }

  private:
    const PiecewiseCubic& source_;
    std::vector<Vec2> points_;
};

}  // namespace cmm::fitting::truth
