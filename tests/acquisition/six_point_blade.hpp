// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "tests/acquisition/session_fixture.hpp"

/// The blade of the session tests with six datum points, and a machine's view of it as it stands askew.
namespace cmm::acquisition {

enum class Datums { touches, middles };

/// On the upper side thrice (or midway between it and the lower one), at the end of smallest x twice, by the nominal's
/// own normals; on the tip with a direction.
inline std::string datum_table(const std::string& kind = "six_points", Datums datums = Datums::touches) {
    const auto nominal = load_nominal(SessionPart().part.nominal).value();
    std::ostringstream text;
    text.precision(12);
    text << "[alignment]\nkind = \"" << kind << "\"\n";
    const auto add = [&](const char* key, double z, auto badness) {
        const auto cut = nominal->cut(z).value();
        const auto at = *std::min_element(cut.points.begin(), cut.points.end(),
                                          [&](const auto& a, const auto& b) { return badness(a) < badness(b); });
        text << key << " = [" << at.x() << ", " << at.y() << ", " << z << "]\n";
    };
    const auto at_x = [](double x, double side) {
        return [=](const Eigen::Vector2d& p) { return std::abs(p.x() - x) < 0.2 ? -side * p.y() : 1e3; };
    };
    for (const auto& [z, x] : {std::pair(10.0, -7.0), std::pair(12.0, 7.0), std::pair(50.0, 1.0)}) {
        text << "[[alignment.point]]\n";
        add("at_mm", z, at_x(x, 1.0));
        if (datums == Datums::middles) add("opposite_mm", z, at_x(x, -1.0));
    }
    for (const double z : {11.0, 49.0}) {
        text << "[[alignment.point]]\n";
        add("at_mm", z, [](const Eigen::Vector2d& p) { return p.x(); });
    }
    text << "[[alignment.point]]\nat_mm = [0, 0, 60]\ndirection = [0, 0, 2]\n";
    return text.str();
}

/// How the part stands on the machine.
inline Eigen::Isometry3d askew() {
    Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
    out.linear() = (Eigen::AngleAxisd(0.006, Eigen::Vector3d(0.5, 0.6, -0.62).normalized())).toRotationMatrix();
    out.translation() = Eigen::Vector3d(0.5, -0.4, 0.45);
    return out;
}

}  // namespace cmm::acquisition
