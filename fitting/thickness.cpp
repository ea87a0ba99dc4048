// SPDX-License-Identifier: Apache-2.0
#include "fitting/thickness.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace cmm::fitting {
namespace {

constexpr std::size_t coarse_points = 160;
constexpr double likely_share = 0.95;        // of the largest of few
constexpr double thickness_rounding = 1e-9;  // far above that of a radius, far below what matters

/// A contour against which circles are tried, with every so many-th of its points for a first guess.
class Obstacles {
  public:
    Obstacles(std::span<const ContourPoint> contour, std::size_t stride, double nearest_mm)
        : stride_(stride), nearest_squared_(nearest_mm * nearest_mm) {
        all_.reserve(contour.size());
        for (const ContourPoint& p : contour)
            all_.push_back(p.position_mm);
        for (std::size_t j = 0; j < all_.size(); j += stride)
            few_.push_back(all_[j]);
        double longest = 0.0;
        for (std::size_t j = 1; j < all_.size(); ++j)
            longest = std::max(longest, (all_[j] - all_[j - 1]).squaredNorm());
        stretch_mm_ = static_cast<double>(stride) * std::sqrt(longest) * (1.0 + thickness_rounding);
    }

    /// Radius of the largest circle that touches the contour at p from inside and holds none of the few other points;
    /// infinite where none lies inwards. Very near neighbours do not count: they only give the local radius of
    /// curvature with all its noise.
    double radius_among_few(const ContourPoint& p) const { return shrunk(infinite, p, few_); }

    /// Among all points: only those whose stretch between two of the few reaches into that circle can matter.
    double radius_among_all(const ContourPoint& p) const {
        double radius = radius_among_few(p);
        for (std::size_t k = 0; k < few_.size(); ++k) {
            const double reach = radius * (1.0 + thickness_rounding) + stretch_mm_;
            if ((few_[k] - p.position_mm + radius * p.normal).squaredNorm() > reach * reach) continue;
            const std::size_t first = k * stride_;
            radius = shrunk(radius, p, std::span(all_).subspan(first, std::min(stride_, all_.size() - first)));
        }
        return radius;
    }

  private:
    double shrunk(double radius, const ContourPoint& p, std::span<const Vec2> points) const {
        double limit = 2.0 * radius * (1.0 + thickness_rounding);
        for (const Vec2& point : points) {
            const Vec2 d = point - p.position_mm;
            const double depth = -d.dot(p.normal), squared = d.squaredNorm();
            // Multiplied first: few points are worth the division.
            if (!(squared < limit * depth) || squared < nearest_squared_) continue;
            radius = std::min(radius, squared / (2.0 * depth));
            limit = 2.0 * radius * (1.0 + thickness_rounding);
        }
        return radius;
    }

    static constexpr double infinite = std::numeric_limits<double>::infinity();

    std::size_t stride_;
    double nearest_squared_, stretch_mm_ = 0.0;  // a bound of the way between two of the few
    std::vector<Vec2> all_, few_;
};

}  // namespace

double largest_inscribed_diameter(std::span<const ContourPoint> contour) {
    const std::size_t n = contour.size(), stride = std::max<std::size_t>(1, n / coarse_points);
    Vec2 low = contour[0].position_mm, high = low;
    for (const ContourPoint& p : contour) {
        low = low.cwiseMin(p.position_mm);
        high = high.cwiseMax(p.position_mm);
    }
    const double nearest = 2e-3 * (high - low).norm();
    const Obstacles obstacles(contour, stride, nearest);
    std::vector<double> coarse;
    for (std::size_t i = 0; i < n; i += stride)
        coarse.push_back(obstacles.radius_among_few(contour[i]));
    double most = 0.0;
    for (const double radius : coarse)
        if (radius < std::numeric_limits<double>::infinity()) most = std::max(most, radius);
    // The maximum is flat, and few points let a circle be too large: all that may be the largest are tried.
    double best = 0.0;
    std::size_t where = 0;
    for (std::size_t k = 0; k < coarse.size(); ++k) {
        if (coarse[k] < likely_share * most || !(coarse[k] < std::numeric_limits<double>::infinity())) continue;
        const double radius = obstacles.radius_among_all(contour[k * stride]);
        if (radius <= best) continue;
        best = radius;
        where = k * stride;
    }
    // The maximum is flat: a few fine points around it settle it.
    best = 0.0;
    for (std::size_t k = 0; k <= 16; ++k) {
        const double radius = obstacles.radius_among_all(contour[(where + n + k * stride / 8 - stride) % n]);
        if (radius < std::numeric_limits<double>::infinity()) best = std::max(best, radius);
    }
    return 2.0 * best;
}

}  // namespace cmm::fitting
