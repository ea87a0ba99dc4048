// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <deque>
#include <vector>

#include "acquisition/section_setup.hpp"
#include "core/units.hpp"
#include "tests/acquisition/session_fixture.hpp"

/// A blade that leans otherwise than its nominal, as a ball of its stylus feels it: what its walls lean by, and what
/// the 2-D offset makes of that, are known by formulas.
namespace cmm::acquisition {

struct LeaningPart {
    SessionPart job;
    Eigen::Vector2d lean = Eigen::Vector2d::Zero();  ///< dx/dz, dy/dz more than the nominal's
    double thicken_mm = 0.0;                         ///< more material on each side
    std::deque<SectionSetup> setups = {};

    LeaningPart(const std::string& text, const Eigen::Vector2d& more_lean, double more_mm = 0.0)
        : job(text), lean(more_lean), thicken_mm(more_mm) {
        for (std::size_t i = 0; i < job.plan.paths.size(); ++i)
            setups.push_back(job.setup(i));
    }
    /// In the plane of the section the ball's centre lies r / cos(lean of the wall) beside the part; at the first
    /// section's height it is that of the nominal.
    std::vector<RecordedPoint> points(std::size_t index) const {
        const SectionSetup& setup = setups[index];
        const double r = setup.ball_radius_mm, rise = setup.z_mm - setups.front().z_mm;
        std::vector<RecordedPoint> points;
        for (const auto& planned : job.plan.paths[index].points) {
            const Eigen::Vector2d n = planned.normal.head<2>(), centre = planned.centre_mm.head<2>();
            const Eigen::Vector3d normal = setup.nominal->reference.touched_normal(centre, n);
            const double slope = normal.z() / normal.head<2>().norm() - n.dot(lean);
            const Eigen::Vector2d at =
                centre + (r * (std::sqrt(1.0 + slope * slope) - 1.0) + thicken_mm) * n + rise * lean;
            RecordedPoint point;
            point.sequence = points.size() + 1;
            point.centre_mm = {at.x(), at.y(), setup.z_mm};
            points.push_back(point);
        }
        return points;
    }
};

/// The session's blade, its walls leaning by 10 degrees in y, at three heights, laid onto the nominal section by
/// section.
inline std::string leaning_text(const std::string& gate, const std::string& more = "") {
    std::string text = session_part_text("0.5") + "[alignment]\nkind = \"section\"\n" + more;
    const auto put = [&](const std::string& from, const std::string& to) {
        text.replace(text.find(from), from.size(), to);
    };
    put("lean_y_deg = -3", "lean_y_deg = 10");
    put("[20, 40]", "[20, 25, 30]");
    put("profile_mm = 0.1\nedge_profile_mm = 0.1\n", gate);
    return text;
}
/// By 2.5 degrees more than that: 9 um too thick for a ball of 1 mm whose offset trusts the nominal.
inline const Eigen::Vector2d leans_more{0.0, std::tan(core::rad_from_deg(12.5)) - std::tan(core::rad_from_deg(10.0))};

/// The same heights without a nominal, half a millimetre less of thickness asked for.
inline std::deque<SectionSetup> too_thick_without_nominal(const LeaningPart& like) {
    std::string text = session_part_text();
    const auto nominal = text.find("[nominal]"), stylus = text.find("[stylus]");
    text.replace(nominal, stylus - nominal, "[nominal]\nkind = \"none\"\n");
    text.replace(text.find("[20, 40]"), 8, "[20, 25, 30]");
    const auto part = parse_part_file(
        text + "[[characteristic]]\nname = \"max_thickness\"\nnominal_mm = 2.3\nupper_mm = 0.1\n", "p.toml");
    EXPECT_TRUE(part) << part.error().text();
    std::deque<SectionSetup> setups;
    for (std::size_t i = 0; i < 3; ++i)
        setups.push_back(make_section_setup(*part, nullptr, i, like.setups[i].z_mm).value());
    return setups;
}

}  // namespace cmm::acquisition
