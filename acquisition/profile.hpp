// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/evaluation.hpp"

namespace cmm::acquisition {

struct ProfileZone {
    fitting::Zone zone;
    const char* name;
    bool edge;
};
inline constexpr std::array profile_zones{ProfileZone{fitting::Zone::le, "profile_le", true},
                                          ProfileZone{fitting::Zone::suction, "profile_suction", false},
                                          ProfileZone{fitting::Zone::te, "profile_te", true},
                                          ProfileZone{fitting::Zone::pressure, "profile_pressure", false}};

/// Deviations of a contour in a frame, filtered, a value for each of its points. A filter takes noise away; the
/// uncertainty stays that of the contour and of the alignment.
struct Compared {
    const std::vector<fitting::ContourPoint>& contour;
    const fitting::FilteredZones& deviation;
    const Alignment& alignment;
    std::string frame;
};

/// 2 max|d| of a zone, judged by the rule with guards that hold for the largest of all its places.
Characteristic profile(const ProfileZone& zone, const SectionResult& section, const Compared& compared,
                       const EvaluationOptions& options);
Characteristic profile_not_evaluable(const ProfileZone& zone, const EvaluationOptions& options, const std::string& why);

/// "worst d +12 um at x 1.000 mm, y 2.000 mm"
std::string worst_note(double deviation_mm, const Eigen::Vector2d& at);

}  // namespace cmm::acquisition
