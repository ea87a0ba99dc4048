// SPDX-License-Identifier: Apache-2.0
#include "acquisition/profile_starts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "acquisition/crv_file.hpp"
#include "core/text.hpp"
#include "tests/acquisition/synthetic_blade.hpp"
#include "tests/acquisition/test_blade.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using Profile = std::vector<Vector2d>;

Profile section(double thickness_mm, double stagger_deg, std::size_t start) {
    synthetic::Shape shape;
    shape.thickness_mm = thickness_mm;
    shape.stagger_rad = core::rad_from_deg(stagger_deg);
    Profile points;
    for (const auto& point : synthetic::Section(shape).contour(120, 60))
        points.push_back(point.position_mm);
    std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(start), points.end());
    return points;
}

/// The same outline with points evenly along it, from a share of its length on.
Profile even(const Profile& profile, std::size_t count, double share) {
    std::vector<double> length{0.0};
    for (std::size_t i = 0; i < profile.size(); ++i)
        length.push_back(length.back() + (profile[(i + 1) % profile.size()] - profile[i]).norm());
    Profile out;
    for (std::size_t k = 0; k < count; ++k) {
        const double s =
            std::fmod(1.0 + share + static_cast<double>(k) / static_cast<double>(count), 1.0) * length.back();
        const auto i = static_cast<std::size_t>(std::upper_bound(length.begin(), length.end(), s) - length.begin()) - 1;
        const double w = (s - length[i]) / (length[i + 1] - length[i]);
        out.push_back((1.0 - w) * profile[i] + w * profile[(i + 1) % profile.size()]);
    }
    return out;
}

TEST(ProfileStarts, AreFoundHoweverTheBladeIsTwistedAndTapered) {
    const std::size_t n = section(6.0, 30.0, 0).size();
    const auto starts = profile_starts({section(6.0, 10.0, 0), section(5.6, 40.0, 3), section(5.2, 75.0, n - 90)});
    EXPECT_EQ(starts.first, (std::vector<std::size_t>{0, n - 3, 90}));
    EXPECT_TRUE(starts.points_agree);
    EXPECT_FALSE(starts.all_at_first());
}

TEST(ProfileStarts, PointsOfOneDrawingStayTogether) {
    EXPECT_TRUE(profile_starts({section(6.0, 10.0, 7), section(3.0, 60.0, 7)}).all_at_first());
    Profile circle;
    for (int i = 0; i < 90; ++i)
        circle.emplace_back(std::cos(core::rad_from_deg(4.0 * i)), std::sin(core::rad_from_deg(4.0 * i)));
    EXPECT_TRUE(profile_starts({circle, circle, circle}).all_at_first()) << "a cylinder is no hyperboloid";
}

TEST(ProfileStarts, SaysWherePointsLieBetweenThoseOfTheNeighbour) {
    const auto outline = section(6.0, 30.0, 0);
    const auto begun = [&](double points) { return even(outline, 200, points / 200.0); };
    EXPECT_TRUE(profile_starts({begun(0.0), begun(37.0)}).points_agree);
    const auto between = profile_starts({begun(0.0), begun(37.5)});
    EXPECT_FALSE(between.points_agree);
    EXPECT_NEAR(static_cast<double>(between.first[1]), 163.0, 1.0);
}

TEST(ProfileStarts, TheShareOppositeIsFoundToAFractionOfAStep) {
    const auto below = even(section(6.0, 30.0, 0), 400, 0.0);
    for (const double share : {-0.4, -0.013, 0.0, 0.2507, 0.31})
        EXPECT_NEAR(share_opposite(below, even(section(5.7, 34.0, 0), 400, share)), -share, 2e-4) << share;
}

TEST(ProfileStarts, OfRealBladesAreTheFirstPoints) {
    const auto folder = std::filesystem::path(real_data("hannover-4ac"));
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (name.find("_") == std::string::npos || entry.path().extension() != ".crv") continue;
        const auto text = core::read_file(entry.path().string());
        ASSERT_TRUE(text) << text.error().text();
        const auto sections = read_crv(*text, name);
        ASSERT_TRUE(sections) << sections.error().text();
        std::vector<Profile> profiles;
        for (const auto& one : *sections) {
            Profile seen;  // their span is y
            for (const auto& p : one.points_mm)
                seen.emplace_back(p.z(), p.x());
            seen.pop_back();  // repeats the first
            profiles.push_back(seen);
        }
        if (std::any_of(profiles.begin(), profiles.end(),
                        [&](const Profile& p) { return p.size() != profiles.front().size(); }))
            continue;
        EXPECT_TRUE(profile_starts(profiles).all_at_first()) << name;
        ++files;
    }
    EXPECT_GE(files, 5U);
}

}  // namespace
}  // namespace cmm::acquisition
