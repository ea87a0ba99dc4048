// SPDX-License-Identifier: Apache-2.0
#include "support/twisted_blade.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/rng.hpp"
#include "support/outline_search.hpp"

namespace cmm::fitting::families {
namespace {

constexpr int station_count = 20;
constexpr double beyond_mm = 3.0;

}  // namespace

TwistedBlade::TwistedBlade(Family family, std::uint64_t seed) : family_(family) {
    const Blade root = make(family, seed);
    root_ = root.shape();
    root_.shift = Vec2::Zero();
    name_ = root.name();
    core::Rng rng = core::Rng::keyed(seed, 0x3D, static_cast<std::uint64_t>(family));
    constexpr double degree = std::numbers::pi / 180.0;
    const double sign = rng.uniform() < 0.5 ? -1.0 : 1.0;
    switch (family) {
        case Family::compressor:
            height_ = root_.chord * rng.uniform(1.2, 2.0);
            twist_ = sign * rng.uniform(18, 35) * degree;
            break;
        case Family::turbine:
            height_ = root_.chord * rng.uniform(1.0, 1.8);
            twist_ = sign * rng.uniform(5, 20) * degree;
            break;
        case Family::fan:
            height_ = root_.chord * rng.uniform(1.8, 2.6);
            twist_ = sign * 55 * degree;
            break;
    }
    taper_ = rng.uniform(0.05, 0.25);
    thinning_ = rng.uniform(0.1, 0.35);
    lean_ = height_ * rng.uniform(-0.08, 0.08);
    sweep_ = height_ * rng.uniform(-0.08, 0.08);
    const double middle = 0.5 * height_, half = middle + beyond_mm;
    for (int m = 0; m < station_count; ++m) {
        const double angle = std::numbers::pi * (2 * m + 1) / (2 * station_count);
        stations_.push_back(middle + half * std::cos(angle));
        barycentric_.push_back((m % 2 == 0 ? 1 : -1) * std::sin(angle));
        outlines_.push_back(outline(stations_.back()));
    }
}

Shape TwistedBlade::shape_at(double z) const {
    const double w = z / height_;
    Shape s = root_;
    s.chord *= 1 - taper_ * w * (0.6 + 0.4 * w);
    s.thickness *= 1 - thinning_ * w;
    for (double* size : {&s.le_along, &s.le_across, &s.te_along, &s.te_across})
        *size *= 1 - 0.6 * thinning_ * w;
    s.camber *= 1 - 0.3 * w;
    s.stagger += twist_ * w * (1.15 - 0.15 * w);
    // Stacked on a point at 45 % of the chord; lean and sweep bend the stacking line.
    const Vec2 stack = Eigen::Rotation2Dd(s.stagger) * Vec2(0.45 * s.chord, 2.0 * s.camber * s.chord);
    s.shift = Vec2(lean_ * w * w, sweep_ * w * (1 + 0.5 * w)) - stack;
    return s;
}

Blade TwistedBlade::outline(double z) const {
    return {shape_at(z), name_};
}

/// Barycentric form (Berrut and Trefethen 2004, eq 4.2 and 9.4).
void TwistedBlade::weights_at(double z, std::vector<double>& weights, std::vector<double>* slopes) const {
    const std::size_t n = stations_.size();
    weights.resize(n);
    double sum = 0.0;
    for (std::size_t m = 0; m < n; ++m) {
        double gap = z - stations_[m];
        if (std::abs(gap) < 1e-9) gap = 1e-9;
        sum += weights[m] = barycentric_[m] / gap;
    }
    for (double& w : weights)
        w /= sum;
    if (slopes == nullptr) return;
    // l_m' = l_m (sum over k of l_k / (z - z_k) - 1 / (z - z_m))
    slopes->resize(n);
    double pull = 0.0;
    const auto gap = [&](std::size_t m) { return std::abs(z - stations_[m]) < 1e-9 ? 1e-9 : z - stations_[m]; };
    for (std::size_t m = 0; m < n; ++m)
        pull += weights[m] / gap(m);
    for (std::size_t m = 0; m < n; ++m)
        (*slopes)[m] = weights[m] * (pull - 1.0 / gap(m));
}

Vec3 TwistedBlade::Jet::normal() const {
    return dt.cross(dz).normalized();
}

TwistedBlade::Jet TwistedBlade::at(double t, double z) const {
    std::vector<double> weights, slopes;
    weights_at(z, weights, &slopes);
    Jet jet{{0, 0, z}, Vec3::Zero(), {0, 0, 1}};
    for (std::size_t m = 0; m < outlines_.size(); ++m) {
        const OutlineJet own = outlines_[m].at(t);
        jet.position.head<2>() += weights[m] * own.position;
        jet.dt.head<2>() += weights[m] * own.d1;
        jet.dz.head<2>() += slopes[m] * own.position;
    }
    return jet;
}

TwistedBlade::Touch TwistedBlade::touch(double t, double z, double ball_mm, double off_mm) const {
    double contact = z;
    Jet jet = at(t, contact);
    for (int step = 0; step < 60; ++step) {
        const double next = z - ball_mm * jet.normal().z();
        const bool still = std::abs(next - contact) < 1e-12;
        contact = next;
        jet = at(t, contact);
        if (still) break;
    }
    const Vec3 n = jet.normal();
    return {jet.position, n, jet.position + (ball_mm + off_mm) * n};
}

OutlineJet TwistedBlade::Section::at(double t) const {
    OutlineJet jet{Vec2::Zero(), Vec2::Zero(), Vec2::Zero()};
    for (std::size_t m = 0; m < weights.size(); ++m) {
        const OutlineJet own = blade->outlines_[m].at(t);
        jet.position += weights[m] * own.position;
        jet.d1 += weights[m] * own.d1;
        jet.d2 += weights[m] * own.d2;
    }
    return jet;
}

TwistedBlade::Section TwistedBlade::section(double z) const {
    Section section;
    section.blade = this;
    weights_at(z, section.weights, nullptr);
    section.samples = sample_outline([&](double t) { return section.at(t); }, 48, 240);
    return section;
}

Foot TwistedBlade::Section::closest(const Vec2& p) const {
    return closest_on_outline([this](double t) { return at(t); }, samples, p);
}

BladeRows scan_rows(const TwistedBlade& blade, std::size_t sections, double lowest, double highest,
                    const ScanOptions& options) {
    BladeRows result;
    for (std::size_t k = 0; k < sections; ++k) {
        const double z = lowest + (highest - lowest) * double(k) / double(std::max<std::size_t>(1, sections - 1));
        ScanOptions own = options;
        own.seed = options.seed * 1000 + k;
        const BladeScan flat = scan(blade.outline(z), own);
        core::Rng rng = core::Rng::keyed(own.seed, 0x30135E, k);
        std::vector<Vec3> row;
        for (std::size_t i = 0; i < flat.t.size(); ++i)
            row.push_back(
                blade.touch(flat.t[i], z, options.ball_mm, options.sigma_mm * rng.normal() + flat.bad[i] + flat.dirt[i])
                    .centre);
        result.heights.push_back(z);
        result.rows.push_back(std::move(row));
        result.bad.push_back(flat.bad);
    }
    return result;
}

}  // namespace cmm::fitting::families
