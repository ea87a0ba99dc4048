// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "support/section_truth.hpp"

namespace cmm::fitting::section_truth {

/// Ball centres without noise, counter-clockwise: so many on each part (LE, pressure, TE, suction), half of them evenly
/// by length of the curve of centres, half by its turning.
inline std::vector<Vec2> exact_scan(const ExactSection& section, double ball_mm,
                                    const std::array<std::size_t, 4>& counts) {
    std::vector<Vec2> points;
    for (int part = 0; part < 4; ++part) {
        constexpr int steps = 4000;
        std::vector<double> way(1, 0.0), turn(1, 0.0);
        OutlineJet last = section.at(part);
        for (int k = 1; k <= steps; ++k) {
            const OutlineJet at = section.at(std::min(part + double(k) / steps, part + 1 - 1e-13));
            const double turned =
                std::abs(std::atan2(last.normal().x() * at.normal().y() - last.normal().y() * at.normal().x(),
                                    last.normal().dot(at.normal())));
            turn.push_back(turn.back() + turned);
            way.push_back(way.back() +
                          (at.position + ball_mm * at.normal() - last.position - ball_mm * last.normal()).norm());
            last = at;
        }
        std::vector<double> measure;
        for (int k = 0; k <= steps; ++k)
            measure.push_back(0.5 * way[static_cast<std::size_t>(k)] / way.back() +
                              0.5 * turn[static_cast<std::size_t>(k)] / std::max(turn.back(), 1e-12));
        const std::size_t count = counts[static_cast<std::size_t>(part)];
        for (std::size_t i = 0; i < count; ++i) {
            const double wanted = (double(i) + 0.5) / double(count);
            const auto above = std::upper_bound(measure.begin() + 1, measure.end() - 1, wanted) - measure.begin();
            const auto k = static_cast<std::size_t>(above - 1);
            const double share = (wanted - measure[k]) / (measure[k + 1] - measure[k]);
            const OutlineJet at = section.at(std::min(part + (double(k) + share) / steps, part + 1 - 1e-13));
            points.push_back(at.position + ball_mm * at.normal());
        }
    }
    return points;
}

}  // namespace cmm::fitting::section_truth
