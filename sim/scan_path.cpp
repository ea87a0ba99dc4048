// SPDX-License-Identifier: Apache-2.0
#include "sim/scan_path.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cmm::sim {
namespace {

constexpr double same_place_mm = 1e-6;

/// Radius of the circle through three points; infinite on a line.
double turning_radius(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const Eigen::Vector3d ab = b - a;
    const Eigen::Vector3d bc = c - b;
    const double twice_area = ab.cross(bc).norm();
    const double sides = ab.norm() * bc.norm() * (c - a).norm();
    if (ab.dot(bc) < 0.0 && twice_area < same_place_mm * same_place_mm) return 0.0;  // straight back
    return twice_area > 0.0 ? sides / (2.0 * twice_area) : HUGE_VAL;
}

}  // namespace

void ScanPath::begin(std::uint16_t id, std::size_t capacity, const PathLimits& limits) {
    *this = ScanPath();
    id_ = id;
    capacity_ = capacity;
    limits_ = limits;
}

ScanPath::Append ScanPath::append(std::uint32_t first, std::span<const PathPoint> points) {
    const auto count = static_cast<std::uint32_t>(points.size());
    if (count == 0 || first > received()) return Append::invalid;
    if (first < received()) return count <= received() - first ? Append::repeated : Append::invalid;
    if (!points_.empty() && points_.back().last) return Append::invalid;
    for (const PathPoint& point : points.first(points.size() - 1))
        if (point.last) return Append::invalid;
    if (received() - passed_ + count > capacity_) return Append::full;
    points_.insert(points_.end(), points.begin(), points.end());
    return Append::taken;
}

void ScanPath::pass(std::uint32_t index) {
    passed_ = index + 1;
    while (base_ + 1 < index) {
        points_.pop_front();
        ++base_;
    }
}

double ScanPath::step_mm(std::uint32_t index) const {
    return (at(index).position - at(index - 1).position).norm();
}

double ScanPath::segment_speed(std::uint32_t index) const {
    const PathPoint& point = at(index);
    double speed = std::min(point.speed_mm_s, limits_.max_speed_mm_s);
    const double step = step_mm(index);
    if (step < same_place_mm) return 0.0;
    if (point.record) speed = std::min(speed, step / limits_.tick_s);
    return speed;
}

double ScanPath::local_speed(std::uint32_t index) const {
    if (index == 0 || !has(index + 1) || at(index).last) return 0.0;
    const double radius = turning_radius(at(index - 1).position, at(index).position, at(index + 1).position);
    return std::min({segment_speed(index), segment_speed(index + 1), std::sqrt(limits_.max_accel_mm_s2 * radius)});
}

double ScanPath::point_speed(std::uint32_t index) const {
    double speed = local_speed(index);
    double way = 0.0;
    for (std::uint32_t next = index + 1; has(next); ++next) {
        way += step_mm(next);
        const double from_way = 2.0 * limits_.max_accel_mm_s2 * way;
        if (from_way >= speed * speed) break;
        const double ahead = local_speed(next);
        speed = std::min(speed, std::sqrt(ahead * ahead + from_way));
    }
    return speed;
}

double ScanPath::turning_per_mm(std::uint32_t index) const {
    if (index == 0) return 0.0;
    const double step = step_mm(index);
    if (step < same_place_mm) return 0.0;
    const Eigen::Vector3d& before = at(index - 1).normal;
    const Eigen::Vector3d& now = at(index).normal;
    return std::atan2(before.cross(now).norm(), before.dot(now)) / step;
}

}  // namespace cmm::sim
