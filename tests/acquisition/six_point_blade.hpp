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

/// On the upper side thrice, at the end of smallest x twice, by the nominal's own normals; on the tip with a direction.
inline std::string datum_table(const std::string& kind = "six_points") {
    const auto nominal = load_nominal(SessionPart().part.nominal).value();
    std::ostringstream text;
    text.precision(12);
    text << "[alignment]\nkind = \"" << kind << "\"\n";
    const auto add = [&](double z, auto badness) {
        const auto cut = nominal->cut(z).value();
        const auto at = *std::min_element(cut.points.begin(), cut.points.end(),
                                          [&](const auto& a, const auto& b) { return badness(a) < badness(b); });
        text << "[[alignment.point]]\nat_mm = [" << at.x() << ", " << at.y() << ", " << z << "]\n";
    };
    const auto above_x = [](double x) {
        return [x](const Eigen::Vector2d& p) { return std::abs(p.x() - x) < 0.2 ? -p.y() : 1e3; };
    };
    const auto leftmost = [](const Eigen::Vector2d& p) { return p.x(); };
    add(10.0, above_x(-7.0));
    add(12.0, above_x(7.0));
    add(50.0, above_x(1.0));
    add(11.0, leftmost);
    add(49.0, leftmost);
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
