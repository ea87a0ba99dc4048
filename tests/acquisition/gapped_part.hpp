// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "acquisition/part_judge.hpp"
#include "tests/acquisition/leaning_part.hpp"

/// The leaning blade, of which not everything was measured.
namespace cmm::acquisition {

using Missing = std::function<bool(const RecordedPoint&, const Eigen::Vector2d& normal)>;

/// The middle third of the suction side.
inline bool on_suction_side(const RecordedPoint& point, const Eigen::Vector2d& normal) {
    return normal.y() > 0.7 && std::abs(point.centre_mm.x()) < 4.0;
}
/// The TE, which lies to the right, and a third of the sides.
inline bool round_the_te(const RecordedPoint& point, const Eigen::Vector2d&) {
    return point.centre_mm.x() > 6.0;
}

/// Judged without the points of these sections that are missing, up to so many sections. Noise: standard deviation
/// across the way.
inline PartResult judged_part_without(const Missing& missing, const std::string& text,
                                      const std::vector<std::size_t>& sections, double thicken_mm = 0.0,
                                      std::size_t count = 100, double noise_mm = 0.0, std::uint64_t seed = 1) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0.0, 1.0);
    const LeaningPart part(text, Eigen::Vector2d::Zero(), thicken_mm);
    PartJudge judge;
    for (std::size_t i = 0; i < std::min(count, part.setups.size()); ++i) {
        auto points = part.points(i);
        const auto& planned = part.job.plan.paths[i].points;
        for (auto& point : points)
            point.centre_mm.head<2>() += noise_mm * noise(random) * planned[point.sequence - 1].normal.head<2>();
        if (std::find(sections.begin(), sections.end(), i) != sections.end()) {
            std::vector<RecordedPoint> left;
            for (const auto& point : points)
                if (!missing(point, planned[point.sequence - 1].normal.head<2>())) left.push_back(point);
            points = left;
        }
        judge.finish(part.setups[i], points);
        judge.grow();
    }
    judge.complete();
    PartResult result;
    result.part_name = "blade";
    result.ball_radius_mm = 1.0;
    result.has_nominal = true;
    result.sections = judge.take();
    return result;
}

}  // namespace cmm::acquisition
