// SPDX-License-Identifier: Apache-2.0
#include "acquisition/clearance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double outline_tolerance_mm = 0.02;
constexpr int grid_heights = 16;
constexpr int directions = 72;
constexpr double check_step_mm = 0.25;

double squared_distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
    const Vector2d d = b - a;
    const double length2 = d.squaredNorm();
    const double t = length2 > 0.0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0.0;
    return (p - a - t * d).squaredNorm();
}

/// Douglas and Peucker 1973, between two kept corners.
void keep_corners(const std::vector<Vector2d>& points, std::size_t from, std::size_t to, std::vector<bool>& keep) {
    std::size_t farthest = from;
    double worst = outline_tolerance_mm * outline_tolerance_mm;
    for (std::size_t i = from + 1; i < to; ++i) {
        const double off = squared_distance_to_segment(points[i], points[from], points[to % points.size()]);
        if (off > worst) {
            worst = off;
            farthest = i;
        }
    }
    if (farthest == from) return;
    keep[farthest] = true;
    keep_corners(points, from, farthest, keep);
    keep_corners(points, farthest, to, keep);
}

Obstacle obstacle_from(const NominalContour& contour) {
    const auto& points = contour.points;
    std::vector<bool> keep(points.size(), false);
    const std::size_t half = points.size() / 2;
    keep[0] = keep[half] = true;
    keep_corners(points, 0, half, keep);
    keep_corners(points, half, points.size(), keep);
    Obstacle obstacle{contour.z_mm, {}};
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (keep[i]) obstacle.outline.push_back(points[i]);
    }
    return obstacle;
}

/// Where a ray from inside the box leaves it.
Vector2d leave_box(const Vector2d& p, const Vector2d& direction, const Vector2d& low, const Vector2d& high) {
    double reach = std::numeric_limits<double>::max();
    for (Eigen::Index k = 0; k < 2; ++k) {
        if (direction[k] > 0.0) reach = std::min(reach, (high[k] - p[k]) / direction[k]);
        if (direction[k] < 0.0) reach = std::min(reach, (low[k] - p[k]) / direction[k]);
    }
    return p + std::max(0.0, reach) * direction;
}

/// Position along the box's boundary, counter-clockwise from the lower left corner.
double along_box(const Vector2d& p, const Vector2d& low, const Vector2d& high) {
    const Vector2d size = high - low;
    const std::array<double, 4> off{std::abs(p.y() - low.y()), std::abs(p.x() - high.x()), std::abs(p.y() - high.y()),
                                    std::abs(p.x() - low.x())};
    const auto side = std::min_element(off.begin(), off.end()) - off.begin();
    if (side == 0) return p.x() - low.x();
    if (side == 1) return size.x() + p.y() - low.y();
    if (side == 2) return size.x() + size.y() + high.x() - p.x();
    return 2.0 * size.x() + size.y() + high.y() - p.y();
}

/// The corners passed on the shorter way round the box.
std::vector<Vector2d> corners_between(const Vector2d& from, const Vector2d& to, const Vector2d& low,
                                      const Vector2d& high) {
    const Vector2d size = high - low;
    const double lap = 2.0 * (size.x() + size.y());
    const std::array<double, 4> at{0.0, size.x(), size.x() + size.y(), 2.0 * size.x() + size.y()};
    const std::array<Vector2d, 4> corner{low, Vector2d(high.x(), low.y()), high, Vector2d(low.x(), high.y())};
    const double a = along_box(from, low, high);
    double ahead = std::fmod(along_box(to, low, high) - a + lap, lap);
    const bool backwards = ahead > 0.5 * lap;
    if (backwards) ahead = lap - ahead;
    std::vector<std::pair<double, Vector2d>> passed;
    for (std::size_t k = 0; k < 4; ++k) {
        const double to_corner = std::fmod((backwards ? a - at.at(k) : at.at(k) - a) + 2.0 * lap, lap);
        if (to_corner > 1e-9 && to_corner < ahead) passed.emplace_back(to_corner, corner.at(k));
    }
    std::sort(passed.begin(), passed.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
    std::vector<Vector2d> corners;
    corners.reserve(passed.size());
    for (const auto& [distance, point] : passed)
        corners.push_back(point);
    return corners;
}

}  // namespace

double distance_to_outline(const Vector2d& p, const std::vector<Vector2d>& outline) {
    double best = std::numeric_limits<double>::max();
    bool inside = false;
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
        best = std::min(best, squared_distance_to_segment(p, a, b));
        const bool crosses = (a.y() > p.y()) != (b.y() > p.y());
        if (crosses && p.x() < a.x() + (p.y() - a.y()) * (b.x() - a.x()) / (b.y() - a.y())) inside = !inside;
    }
    return inside ? -std::sqrt(best) : std::sqrt(best);
}

bool Clearance::outside(const Vector3d& p) const {
    constexpr double on_the_side_mm = 1e-6;
    return p.z() >= top_mm || p.x() <= low_mm.x() + on_the_side_mm || p.y() <= low_mm.y() + on_the_side_mm ||
           p.x() >= high_mm.x() - on_the_side_mm || p.y() >= high_mm.y() - on_the_side_mm;
}

double Clearance::gap_mm(const Vector3d& p) const {
    double gap = std::numeric_limits<double>::max();
    for (const auto& obstacle : obstacles) {
        const double rise = obstacle.z_mm - p.z();
        if (rise < -stylus.radius_mm || rise > stylus.length_mm) continue;
        const double radius = rise <= stylus.radius_mm ? stylus.radius_mm : stylus.shank_radius_mm;
        gap = std::min(gap, distance_to_outline(p.head<2>(), obstacle.outline) - radius);
    }
    return gap;
}

std::optional<Vector2d> Clearance::way_from(const Vector3d& p) const {
    const Vector2d plane = p.head<2>();
    if (obstacles.empty()) {
        const Vector2d direction = way_out.value_or(Vector2d(plane - 0.5 * (low_mm + high_mm)));
        return leave_box(plane, direction.norm() > 0.0 ? direction.normalized() : Vector2d(1.0, 0.0), low_mm, high_mm);
    }
    // On the way out the room may not become less than it is here, nor than a quarter of a millimetre where it is more.
    const double needed = std::min(gap_mm(p), 0.25) - 1e-9;
    std::optional<Vector2d> best;
    double best_score = std::numeric_limits<double>::max();
    for (int k = 0; k < directions; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / directions;
        const Vector2d exit = leave_box(plane, {std::cos(angle), std::sin(angle)}, low_mm, high_mm);
        const double length = (exit - plane).norm();
        if (length >= best_score) continue;
        bool free = true;
        for (double s = check_step_mm; free && s < length;) {
            const Vector2d at = plane + (exit - plane) * (s / length);
            const double room = gap_mm({at.x(), at.y(), p.z()}) - needed;
            free = room >= 0.0;
            s += std::max(check_step_mm, room);  // the room changes by no more than the way
        }
        if (!free) continue;
        best = exit;
        best_score = length;
    }
    return best;
}

std::vector<Vector3d> Clearance::route(const Vector3d& from, const Vector3d& to) const {
    const auto on_box = [this](const Vector3d& p) -> std::optional<Vector2d> {
        if (!outside(p)) return way_from(p);
        const Vector2d plane = p.head<2>();
        if ((plane.array() >= low_mm.array()).all() && (plane.array() <= high_mm.array()).all()) {
            return leave_box(plane, (plane - 0.5 * (low_mm + high_mm)).normalized(), low_mm, high_mm);
        }
        return Vector2d(plane.cwiseMax(low_mm).cwiseMin(high_mm));
    };
    const auto out = on_box(from), in = on_box(to);
    if (!out || !in) return {};
    std::vector<Vector3d> way;
    const auto add = [&](const Vector2d& p, double z) {
        const Vector3d point(p.x(), p.y(), z);
        if ((point - (way.empty() ? from : way.back())).norm() > 1e-6) way.push_back(point);
    };
    add(*out, from.z());
    add(*out, to.z());
    for (const auto& corner : corners_between(*out, *in, low_mm, high_mm))
        add(corner, to.z());
    add(*in, to.z());
    add(to.head<2>(), to.z());
    if (way.empty()) way.push_back(to);
    return way;
}

Clearance make_clearance(const PartFile& part, const Nominal* nominal, const std::vector<NominalContour>& cuts) {
    Clearance clearance;
    clearance.stylus = part.stylus;
    const double margin = part.scan.clearance_mm + part.stylus.radius_mm;
    const Vector2d around(margin, margin);
    if (nominal == nullptr) {
        const auto& box = part.scan.box_mm.value();
        clearance.low_mm = Vector2d(box[0], box[1]) - around;
        clearance.high_mm = Vector2d(box[2], box[3]) + around;
        clearance.top_mm = std::numeric_limits<double>::max();  // nobody knows how high the part is
        return clearance;
    }
    for (const auto& cut : cuts)
        clearance.obstacles.push_back(obstacle_from(cut));
    for (int k = 0; k <= grid_heights; ++k) {
        const double z = nominal->z_low_mm() + (nominal->z_high_mm() - nominal->z_low_mm()) * k / grid_heights;
        // Near its ends a mesh may have no single contour; the neighbours stand for it.
        if (const auto cut = nominal->cut(z)) clearance.obstacles.push_back(obstacle_from(*cut));
    }
    std::sort(clearance.obstacles.begin(), clearance.obstacles.end(),
              [](const Obstacle& a, const Obstacle& b) { return a.z_mm < b.z_mm; });
    clearance.low_mm = Vector2d::Constant(std::numeric_limits<double>::max());
    clearance.high_mm = -clearance.low_mm;
    for (const auto& obstacle : clearance.obstacles) {
        for (const auto& p : obstacle.outline) {
            clearance.low_mm = clearance.low_mm.cwiseMin(p);
            clearance.high_mm = clearance.high_mm.cwiseMax(p);
        }
    }
    clearance.low_mm -= around;
    clearance.high_mm += around;
    clearance.top_mm = nominal->z_high_mm() + margin;
    return clearance;
}

}  // namespace cmm::acquisition
