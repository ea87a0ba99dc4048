// SPDX-License-Identifier: Apache-2.0
#include "support/airfoil.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "support/naca65.hpp"

namespace cmm::fitting::airfoil {
namespace {

constexpr double camber_mm = 60.6, camber_rad = 35.0 * std::numbers::pi / 180.0;
constexpr double le_mm = 0.4, te_mm = 0.25, te_slope = -0.1;
constexpr double root_mm = 0.3, root_factor = 0.55;  // radius = le + factor (sqrt(s + root) - sqrt(root)) + ...
constexpr int side_points = 60000, edge_points = 8000;

/// Share of a scan's points on each part.
std::array<double, 4> shares_of(Airfoil::Spacing spacing, const std::array<double, 4>& lengths) {
    switch (spacing) {
        case Airfoil::Spacing::edges:
            return {0.38, 0.12, 0.38, 0.12};
        case Airfoil::Spacing::cosine:
            return {0.46, 0.04, 0.46, 0.04};
        case Airfoil::Spacing::even:
            break;
    }
    const double all = std::accumulate(lengths.begin(), lengths.end(), 0.0);
    return {lengths[0] / all, lengths[1] / all, lengths[2] / all, lengths[3] / all};
}

/// Share of a part's points up to a share of its length.
double points_up_to(double length_share, bool by_cosine) {
    if (!by_cosine) return length_share;
    return std::acos(std::clamp(1.0 - 2.0 * length_share, -1.0, 1.0)) / std::numbers::pi;
}

}  // namespace

Airfoil::Airfoil(double offset_mm) : offset_(offset_mm) {
    // Square and cube terms bring radius and slope to those of the TE.
    const double length = camber_mm;
    const double radius_gap = te_mm - le_mm - root_factor * (std::sqrt(length + root_mm) - std::sqrt(root_mm));
    const double slope_gap = te_slope - 0.5 * root_factor / std::sqrt(length + root_mm);
    cube_ = (slope_gap * length - 2.0 * radius_gap) / (length * length * length);
    square_ = (radius_gap - cube_ * length * length * length) / (length * length);
    add_side(false);
    add_edge(camber_mm, te_mm + offset_, normals_.back());
    add_side(true);
    add_edge(0.0, le_mm + offset_, normals_.back());
    measure_lengths();
}

Airfoil Airfoil::naca_65(double offset_mm) {
    Airfoil airfoil{Empty{}};
    for (const auto& [position, normal, part] : naca65::outline(offset_mm))
        airfoil.add(position, normal, part);
    airfoil.measure_lengths();
    return airfoil;
}

void Airfoil::measure_lengths() {
    length_.assign(1, 0.0);
    for (std::size_t i = 0; i < points_.size(); ++i)
        length_.push_back(length_.back() + (points_[(i + 1) % points_.size()] - points_[i]).norm());
}

double Airfoil::radius(double s) const {
    return le_mm + offset_ + root_factor * (std::sqrt(s + root_mm) - std::sqrt(root_mm)) + square_ * s * s +
           cube_ * s * s * s;
}

double Airfoil::radius_slope(double s) const {
    return 0.5 * root_factor / std::sqrt(s + root_mm) + 2.0 * square_ * s + 3.0 * cube_ * s * s;
}

Airfoil::Camber Airfoil::camber(double s) const {
    const double curvature = camber_rad / camber_mm, angle = curvature * (s - 0.5 * camber_mm);
    return {Vec2(std::sin(angle), std::cos(angle) - 1.0) / curvature, Vec2(std::cos(angle), -std::sin(angle)),
            Vec2(std::sin(angle), std::cos(angle))};
}

void Airfoil::add(const Vec2& position, const Vec2& normal, int part) {
    points_.push_back(position);
    normals_.push_back(normal);
    part_.push_back(part);
}

void Airfoil::add_side(bool upper) {
    for (int i = 0; i < side_points; ++i) {
        const double share = 0.5 - 0.5 * std::cos(std::numbers::pi * i / (side_points - 1));
        const double s = camber_mm * (upper ? 1.0 - share : share);
        const Camber c = camber(s);
        const double slope = radius_slope(s);
        const Vec2 normal = -slope * c.along + (upper ? 1.0 : -1.0) * std::sqrt(1.0 - slope * slope) * c.across;
        add(c.position + radius(s) * normal, normal, upper ? 2 : 0);
    }
}

/// Counter-clockwise from a normal to its mirror image about the camber line.
void Airfoil::add_edge(double s, double radius, const Vec2& from) {
    const Camber c = camber(s);
    const Vec2 to = 2.0 * from.dot(c.along) * c.along - from;
    for (const Vec2& normal : naca65::normals_between(from, to, edge_points))
        add(c.position + radius * normal, normal, s > 0.0 ? 1 : 3);
}

std::vector<Vec2> Airfoil::scan(std::size_t count, Spacing spacing, double sigma_mm, std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise;
    const std::size_t n = points_.size();
    std::array<double, 4> total{}, gone{};
    for (std::size_t i = 0; i < n; ++i)
        total[part_[i]] += length_[i + 1] - length_[i];
    const auto of_part = shares_of(spacing, total);
    std::vector<double> share(1, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
        const int part = part_[i];
        const bool by_cosine = spacing == Spacing::cosine && part % 2 == 0;
        const double before = points_up_to(gone[part] / total[part], by_cosine);
        gone[part] += length_[i + 1] - length_[i];
        share.push_back(share.back() + of_part[part] * (points_up_to(gone[part] / total[part], by_cosine) - before));
    }
    const double first = std::uniform_real_distribution<double>()(random);
    std::vector<Vec2> scan;
    for (std::size_t k = 0; k < count; ++k) {
        const double at = share.back() * (static_cast<double>(k) + first) / static_cast<double>(count);
        const auto above = std::upper_bound(share.begin(), share.end(), at) - share.begin();
        const auto i = std::min<std::size_t>(static_cast<std::size_t>(above) - 1, n - 1), j = (i + 1) % n;
        const double part = (at - share[i]) / (share[i + 1] - share[i]);
        const Vec2 normal = ((1.0 - part) * normals_[i] + part * normals_[j]).normalized();
        scan.push_back((1.0 - part) * points_[i] + part * points_[j] + sigma_mm * noise(random) * normal);
    }
    const auto start = std::uniform_int_distribution<std::ptrdiff_t>(0, static_cast<std::ptrdiff_t>(count) - 1)(random);
    std::rotate(scan.begin(), scan.begin() + start, scan.end());
    return scan;
}

double Airfoil::distance(const Vec2& p, std::size_t& near) const {
    const std::size_t n = points_.size();
    const auto squared = [&](std::size_t i) { return (points_[i % n] - p).squaredNorm(); };
    if (near == 0)
        for (std::size_t i = 0; i < n; i += 50)
            if (squared(i) < squared(near)) near = i;
    for (const std::size_t step : {4096U, 512U, 64U, 8U, 1U})
        for (bool moved = true; moved;) {
            moved = false;
            for (const std::size_t other : {near + step, near + n - step})
                if (squared(other) < squared(near)) {
                    near = other % n;
                    moved = true;
                }
        }
    double best = std::numeric_limits<double>::infinity(), signed_distance = 0.0;
    for (const std::size_t i : {(near + n - 1) % n, near}) {
        const std::size_t j = (i + 1) % n;
        const Vec2 step = points_[j] - points_[i];
        const double part = std::clamp((p - points_[i]).dot(step) / step.squaredNorm(), 0.0, 1.0);
        const Vec2 off = p - points_[i] - part * step;
        if (off.norm() >= best) continue;
        best = off.norm();
        signed_distance = off.dot((1.0 - part) * normals_[i] + part * normals_[j]);
    }
    return signed_distance;
}

}  // namespace cmm::fitting::airfoil
