// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "support/families.hpp"

namespace cmm::fitting::families {

using OutlineSamples = std::array<std::vector<Vec2>, 4>;

/// Points of an outline at(t), t in [0, 4), evenly by parameter on each part.
template <class At>
OutlineSamples sample_outline(const At& at, int end_steps, int side_steps) {
    OutlineSamples samples;
    for (std::size_t part = 0; part < 4; ++part) {
        const int steps = part % 2 == 0 ? end_steps : side_steps;
        for (int k = 0; k <= steps; ++k)
            samples[part].push_back(at(std::min(double(part) + double(k) / steps, double(part) + 1 - 1e-15)).position);
    }
    return samples;
}

/// Foot point on an outline by Newton's method from the nearest sample of each part.
template <class At>
Foot closest_on_outline(const At& at, const OutlineSamples& samples, const Vec2& p) {
    std::array<std::pair<double, std::size_t>, 4> nearest;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t part = 0; part < 4; ++part) {
        nearest[part] = {std::numeric_limits<double>::infinity(), 0};
        for (std::size_t k = 0; k < samples[part].size(); ++k)
            nearest[part] = std::min(nearest[part], {(samples[part][k] - p).norm(), k});
        best = std::min(best, nearest[part].first);
    }
    Foot foot;
    double squared = std::numeric_limits<double>::infinity();
    for (std::size_t part = 0; part < 4; ++part) {
        const auto& s = samples[part];
        if (nearest[part].first > best + (s[s.size() / 2] - s[s.size() / 2 - 1]).norm()) continue;
        const double low = double(part), high = low + 1 - 1e-15;
        double t = std::min(high, low + double(nearest[part].second) / double(s.size() - 1));
        OutlineJet jet = at(t);
        for (int step = 0; step < 40; ++step) {
            const Vec2 off = jet.position - p;
            const double newton = jet.d1.squaredNorm() + off.dot(jet.d2);
            const double move = -off.dot(jet.d1) / (newton > 0 ? newton : jet.d1.squaredNorm());
            const double to = std::clamp(t + std::clamp(move, -0.05, 0.05), low, high);
            const bool still = std::abs(to - t) < 1e-14;
            t = to;
            jet = at(t);
            if (still) break;
        }
        if (const double d = (jet.position - p).squaredNorm(); d < squared) {
            squared = d;
            foot = {t, std::copysign(std::sqrt(d), (p - jet.position).dot(jet.normal()))};
        }
    }
    return foot;
}

}  // namespace cmm::fitting::families
