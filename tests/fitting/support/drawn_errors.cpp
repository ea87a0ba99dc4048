// SPDX-License-Identifier: Apache-2.0
#include "support/drawn_errors.hpp"

#include <cmath>
#include <numbers>

namespace cmm::fitting::drawn_errors {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d pair(core::Rng& rng, double standard) {
    const double cosine = standard * rng.normal();
    return {cosine, standard * rng.normal()};
}

}  // namespace

Vector3d Machine::of(const Vector3d& place_mm, const Vector3d& normal, double share) const {
    const double direction = std::atan2(normal.y(), normal.x());
    double outwards = ball_mm + constant_mm;
    for (std::size_t m = 1; m < lobes.size(); ++m) {
        const double angle = static_cast<double>(m) * direction;
        outwards += lobes[m].mm.dot(Vector2d(std::cos(angle), std::sin(angle)));
    }
    for (std::size_t k = 0; k < waves.size(); ++k) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(k + 1) * share;
        outwards += waves[k].mm.dot(Vector2d(std::cos(angle), std::sin(angle)));
    }
    return outwards * normal + strain * place_mm + growth * place_mm;
}

SystematicErrors usual_errors() {
    const double rectangular = std::sqrt(3.0);
    SystematicErrors errors;
    errors.constant_mm = 1.9e-3 / rectangular;
    errors.per_mm = 1e-3 / 300.0 / rectangular;
    errors.form_mm = 0.5 * 1.9e-3 / rectangular;
    errors.ball_mm = 0.5 * 1.9e-3 / rectangular;
    errors.expansion = 11.5e-6 * 0.5;
    return errors;
}

void draw_waves(const SystematicErrors& errors, core::Rng& rng, Machine& machine) {
    const double each = 0.5 * errors.constant_mm / std::sqrt(static_cast<double>(machine.waves.size()));
    for (auto& wave : machine.waves)
        wave.mm = pair(rng, each);
}

Machine draw(const SystematicErrors& errors, core::Rng& rng) {
    Machine machine;
    machine.ball_mm = errors.ball_mm * rng.normal();
    machine.constant_mm = 0.25 * errors.constant_mm * rng.normal();
    for (std::size_t m = 1; m < machine.lobes.size(); ++m) {
        if (m <= 3) machine.lobes[m].mm += pair(rng, 0.25 * errors.constant_mm);
        if (m >= 2) machine.lobes[m].mm += pair(rng, errors.form_mm / std::sqrt(3.0));
    }
    for (int i = 0; i < 3; ++i) {
        machine.strain(i, i) = errors.per_mm * rng.normal();
        for (int k = 0; k < i; ++k)
            machine.strain(i, k) = machine.strain(k, i) = errors.per_mm / std::sqrt(2.0) * rng.normal();
    }
    machine.growth = errors.expansion * rng.normal() + errors.known_expansion;
    draw_waves(errors, rng, machine);
    return machine;
}

void displace(const families::Blade& blade, const Machine& machine, families::BladeScan& scan, double z_mm) {
    std::vector<double> way{0.0};
    for (std::size_t i = 1; i < scan.points.size(); ++i)
        way.push_back(way.back() + (scan.points[i] - scan.points[i - 1]).norm());
    const double length = way.back() + (scan.points.front() - scan.points.back()).norm();
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
        const auto at = blade.at(scan.t[i]);
        const Vector2d normal = at.normal();
        const Vector3d by =
            machine.of({at.position.x(), at.position.y(), z_mm}, {normal.x(), normal.y(), 0.0}, way[i] / length);
        scan.points[i] += by.head<2>();
    }
}

}  // namespace cmm::fitting::drawn_errors
