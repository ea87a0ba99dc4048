// SPDX-License-Identifier: Apache-2.0
#include "support/natural_blade.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/rng.hpp"

namespace cmm::fitting::natural {
namespace {

constexpr std::size_t samples = 4000, points = 600, points_of_nose = 72;
constexpr double sigma_mm = 1e-3, bad_share = 0.015, bad_low_mm = 0.020, bad_high_mm = 0.400;

}  // namespace

Blade::Blade(std::uint64_t seed, bool slender, double le_share) {
    core::Rng rng = core::Rng::keyed(seed, slender ? 0xFA : 0x7B, 0);
    chord_ = slender ? rng.uniform(90.0, 160.0) : rng.uniform(25.0, 50.0);
    thickness_ = chord_ * (slender ? rng.uniform(0.02, 0.04) : rng.uniform(0.14, 0.22));
    camber_ = chord_ * (slender ? rng.uniform(0.01, 0.05) : rng.uniform(0.12, 0.22));
    le_radius_ = le_share * rng.uniform(0.9, 1.35) * thickness_ * thickness_ / chord_;  // 1.1 of NACA's
    te_radius_ = slender ? rng.uniform(0.2, 0.4) : rng.uniform(0.3, 0.7);
    stagger_ = rng.uniform(0.3, 0.8);
    for (std::size_t k = 0; k < samples; ++k)
        samples_.push_back(at(static_cast<double>(k) / samples).position);
}

Blade::Jet Blade::at(double u) const {
    // Along the chord x = w chord, w = (1 + cos a)/2; half the thickness sin a times a polynomial of w.
    const double a = 2.0 * std::numbers::pi * u, w = 0.5 * (1.0 + std::cos(a)), v = 1.0 - w, s = std::sin(a);
    const double dw = -0.5 * s, ds = std::cos(a);  // by a
    const double le = std::sqrt(0.5 * le_radius_ * chord_), te = std::sqrt(0.5 * te_radius_ * chord_);
    const double middle = 0.25 * thickness_ / std::sqrt(0.4 * 0.6);
    const double p = 3.15 * middle, q = 2.85 * middle;
    const double f = le * v * v * v + p * v * v * w + q * v * w * w + te * w * w * w;
    const double df = -3.0 * le * v * v + p * (v * v - 2.0 * v * w) + q * (2.0 * v * w - w * w) + 3.0 * te * w * w;
    const double half = s * f, dhalf = ds * f + s * df * dw;
    // y = 4 camber w v (1.2 - 0.4 w), its slope by x, and the bend of that.
    const double y = 4.0 * camber_ * w * v * (1.2 - 0.4 * w);
    const double slope = 4.0 * camber_ / chord_ * ((1.0 - 2.0 * w) * (1.2 - 0.4 * w) - 0.4 * w * v);
    const double bend = 4.0 * camber_ / chord_ * (-2.0 * (1.2 - 0.4 * w) - 0.8 * (1.0 - 2.0 * w));
    const double root = std::hypot(1.0, slope), turn = bend * dw / (root * root);
    const Vec2 along = Vec2(1.0, slope) / root, across = Vec2(-slope, 1.0) / root;
    Jet jet;
    jet.position = Vec2(chord_ * w, y) + half * across;
    jet.d1 = chord_ * dw * root * along + dhalf * across - half * turn * along;
    Eigen::Matrix2d rotation;
    rotation << std::cos(stagger_), -std::sin(stagger_), std::sin(stagger_), std::cos(stagger_);
    jet.position = (rotation * jet.position).eval();
    jet.d1 = (2.0 * std::numbers::pi * rotation * jet.d1).eval();
    return jet;
}

double Blade::distance(const Vec2& p) const {
    const auto nearest = std::min_element(samples_.begin(), samples_.end(), [&](const Vec2& a, const Vec2& b) {
        return (a - p).squaredNorm() < (b - p).squaredNorm();
    });
    double u = static_cast<double>(nearest - samples_.begin()) / samples;
    Jet jet = at(u);
    for (int step = 0; step < 12; ++step) {
        u += (p - jet.position).dot(jet.d1) / jet.d1.squaredNorm();
        jet = at(u);
    }
    return (p - jet.position).dot(jet.normal());
}

Blade::Scan Blade::scan(std::uint64_t seed, double ball_mm, double edge_radii) const {
    std::vector<double> length{0.0};
    for (std::size_t k = 1; k <= samples; ++k)
        length.push_back(length.back() + (samples_[k % samples] - samples_[k - 1]).norm());
    const double whole = length.back(), to_le = length[samples / 2];
    const double le = edge_radii * le_radius_, te = edge_radii * te_radius_;
    const std::array<double, 5> ends{te, to_le - le, to_le + le, whole - te, whole + te};
    constexpr std::size_t of_sides = points - 2 * points_of_nose;
    const double suction = ends[1] - ends[0], pressure = ends[3] - ends[2];
    const auto of_suction = static_cast<std::size_t>(std::lround(of_sides * suction / (suction + pressure)));
    const std::array<std::size_t, 4> counts{of_suction, points_of_nose, of_sides - of_suction, points_of_nose};
    core::Rng rng = core::Rng::keyed(seed, 0x5C, 0);
    Scan out;
    out.le_first = of_suction;
    for (std::size_t part = 0; part < counts.size(); ++part)
        for (std::size_t k = 0; k < counts[part]; ++k) {
            const double step = (ends[part + 1] - ends[part]) / static_cast<double>(counts[part]);
            const double s = std::fmod(ends[part] + step * static_cast<double>(k), whole);
            const auto above = std::upper_bound(length.begin(), length.end(), s);
            const double share = (s - *(above - 1)) / (*above - *(above - 1));
            const Jet jet = at((static_cast<double>(above - length.begin()) - 1.0 + share) / samples);
            out.centres.emplace_back(jet.position + (ball_mm + sigma_mm * rng.normal()) * jet.normal());
            out.bad_mm.push_back(0.0);
        }
    for (std::size_t bad = 0; static_cast<double>(bad) < bad_share * points;) {
        const auto first = static_cast<std::size_t>(rng.uniform(0.0, points));
        const auto run = 1 + static_cast<std::size_t>(rng.uniform(0.0, 3.0));
        for (std::size_t k = first; k < first + run; ++k) {
            double& off = out.bad_mm[k % points];
            if (off != 0.0) continue;
            off = rng.uniform(bad_low_mm, bad_high_mm);
            ++bad;
        }
    }
    std::vector<Vec2> moved = out.centres;
    for (std::size_t k = 0; k < points; ++k) {
        const Vec2 along = out.centres[(k + 1) % points] - out.centres[(k + points - 1) % points];
        moved[k] += out.bad_mm[k] * Vec2(along.y(), -along.x()).normalized();
    }
    out.centres = std::move(moved);
    return out;
}

}  // namespace cmm::fitting::natural
