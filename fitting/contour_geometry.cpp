// SPDX-License-Identifier: Apache-2.0
#include "fitting/contour_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmm::fitting {
namespace {

constexpr std::size_t coarse_step = 12;
constexpr std::size_t slope_reach = 2;  // points to either side of a slope

/// Where a function that is linear between two points vanishes.
double root_between(double at_0, double at_1) {
    const double fall = at_0 - at_1;
    return std::abs(fall) > 1e-300 ? std::clamp(at_0 / fall, 0.0, 1.0) : 0.5;
}

}  // namespace

ContourGeometry::ContourGeometry(std::span<const ContourPoint> contour) : contour_(contour) {
    perimeter_ = contour.back().arc_length_mm + (contour.front().position_mm - contour.back().position_mm).norm();
}

Vec2 ContourGeometry::position(const ContourPlace& place) const {
    const Vec2 &a = point(place.index).position_mm, &b = point(place.index + 1).position_mm;
    const double u = place.share, v = 1.0 - u, length = (b - a).norm();
    return (1.0 + 2.0 * u) * v * v * a + u * u * (3.0 - 2.0 * u) * b +
           length * u * v * (v * tangent(place.index) - u * tangent(place.index + 1));
}

Vec2 ContourGeometry::normal(const ContourPlace& place) const {
    const Vec2 &a = point(place.index).normal, &b = point(place.index + 1).normal;
    return (a + place.share * (b - a)).normalized();
}

double ContourGeometry::arc(const ContourPlace& place) const {
    const Vec2 step = point(place.index + 1).position_mm - point(place.index).position_mm;
    return point(place.index).arc_length_mm + place.share * step.norm();
}

std::size_t ContourGeometry::nearest_point(const Vec2& p) const {
    const auto nearer = [&](const ContourPoint& a, const ContourPoint& b) {
        return (a.position_mm - p).squaredNorm() < (b.position_mm - p).squaredNorm();
    };
    return static_cast<std::size_t>(std::min_element(contour_.begin(), contour_.end(), nearer) - contour_.begin());
}

ContourPlace ContourGeometry::farthest(const Vec2& direction, const ContourRange& range) const {
    std::size_t best = range.first;
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < range.count; ++k) {
        const double along = point(range.first + k).position_mm.dot(direction);
        if (along <= most) continue;
        most = along;
        best = range.first + k;
    }
    // Counter-clockwise the way along the direction rises before the place and falls behind it.
    const auto rise = [&](std::size_t i) { return tangent(i).dot(direction); };
    const std::size_t n = size();
    const std::size_t from = rise(best) < 0.0 ? best + n - 1 : best;
    if (rise(from) < 0.0 || rise(from + 1) > 0.0) return {best % n, 0.0};
    return {from % n, root_between(rise(from), rise(from + 1))};
}

ContourPlace ContourGeometry::foot(const Vec2& p, const ContourRange& range, const ContourPlace* near) const {
    std::size_t best = near != nullptr ? std::min((near->index + size() - range.first) % size(), range.count - 1) : 0;
    double least = std::numeric_limits<double>::infinity();
    const auto look = [&](std::size_t k) {
        const double squared = (point(range.first + k).position_mm - p).squaredNorm();
        if (squared >= least) return;
        least = squared;
        best = k;
    };
    for (std::size_t k = 0; near == nullptr && k < range.count; k += coarse_step)
        look(k);
    const std::size_t low = best > coarse_step ? best - coarse_step : 0;
    const std::size_t high = std::min(range.count, best + coarse_step + 1);
    for (std::size_t k = low; k < high; ++k)
        look(k);
    const auto away = [&](std::size_t k) {
        return (point(range.first + k).position_mm - p).dot(tangent(range.first + k));
    };
    const std::size_t n = size();
    if (away(best) > 0.0) {
        if (best == 0) return {range.first % n, 0.0};
        --best;
    } else if (best + 1 >= range.count) {
        return {(range.first + best) % n, 0.0};
    }
    const double a = away(best), b = away(best + 1);
    if (a > 0.0 || b < 0.0) return {(range.first + best) % n, 0.5};
    // One step of the false position on the curve itself: the length is then exact to rounding.
    ContourPlace place{(range.first + best) % n, root_between(a, b)};
    const Vec2 off = position(place) - p;
    const double left = off.dot(left_of(normal(place)));
    if (left < 0.0)
        place.share += (1.0 - place.share) * root_between(left, b);
    else
        place.share *= root_between(a, left);
    return place;
}

ContourPlace ContourGeometry::crossing(const Vec2& p, const Vec2& direction, const ContourRange& range) const {
    const Vec2 across = left_of(direction);
    const std::size_t n = size();
    ContourPlace best{n, 0.0};
    double least = std::numeric_limits<double>::infinity();
    const auto beside = [&](const ContourPlace& place) { return (position(place) - p).dot(across); };
    for (std::size_t k = 0; k + 1 < range.count; ++k) {
        const std::size_t i = (range.first + k) % n;
        const double a = (point(i).position_mm - p).dot(across), b = (point(i + 1).position_mm - p).dot(across);
        if ((a > 0.0) == (b > 0.0) && a != 0.0) continue;
        ContourPlace place{i, root_between(a, b)};
        const double left = beside(place);
        if ((left > 0.0) == (a > 0.0))
            place.share += (1.0 - place.share) * root_between(left, b);
        else
            place.share *= root_between(a, left);
        if (const double far = (position(place) - p).squaredNorm(); far < least) {
            least = far;
            best = place;
        }
    }
    return best;
}

void ContourGeometry::add(const ContourPlace& place, double weight, Sensitivity& number) const {
    number.add(place.index % size(), weight * (1.0 - place.share));
    if (place.share > 0.0) number.add((place.index + 1) % size(), weight * place.share);
}

void ContourGeometry::add_slope(const ContourPlace& place, double weight, Sensitivity& number) const {
    const std::size_t n = size(), i = place.index + (place.share > 0.5 ? 1 : 0);
    const std::size_t behind = (i + n - slope_reach) % n, ahead = (i + slope_reach) % n;
    double length = point(ahead).arc_length_mm - point(behind).arc_length_mm;
    if (length <= 0.0) length += perimeter_;
    number.add(ahead, weight / length);
    number.add(behind, -weight / length);
}

}  // namespace cmm::fitting
