// SPDX-License-Identifier: Apache-2.0
#include "fitting/curvature_joints.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>
#include <random>

#include "fitting/section.hpp"
#include "fitting/smoothing.hpp"
#include "support/families.hpp"

namespace cmm::fitting {
namespace {

using std::numbers::pi;

/// Spans of 0.1 with a curvature that falls by `slope` each millimetre up to `at` and is level from there, where it
/// falls by `step` over `width`.
struct Profile {
    std::vector<double> breaks, slope, length;

    Profile(double at, double step, double width, double own_slope) {
        const auto share = [&](double s) { return std::clamp((s - at) / width + 0.5, 0.0, 1.0); };
        const auto curvature = [&](double s) { return own_slope * std::min(s, at) + step * share(s); };
        for (int k = 0; k <= 60; ++k)
            breaks.push_back(0.1 * k);
        for (int k = 0; k < 60; ++k) {
            length.push_back(0.1);
            slope.push_back((curvature(0.1 * (k + 1)) - curvature(0.1 * k)) / 0.1);
        }
    }
};

TEST(CurvatureJoints, AreFoundBetweenTheKnots) {
    for (const double at : {2.95, 3.0, 3.02, 3.08})
        for (const double own_slope : {0.0, -0.5}) {
            const Profile profile(at, -0.6, 0.15, own_slope);
            const auto joints = find_curvature_joints(profile.breaks, profile.slope, profile.length, 1e-6);
            ASSERT_EQ(joints.size(), 1U) << at;
            EXPECT_NEAR(joints[0].t, at, 0.02);
            EXPECT_NEAR(joints[0].step, -0.6, 0.03);
        }
}

TEST(CurvatureJoints, AreNoneWhereTheCurvatureOnlySlopes) {
    const Profile level(3.0, 0.0, 0.1, -0.5);
    EXPECT_TRUE(find_curvature_joints(level.breaks, level.slope, level.length, 1e-6).empty());
    const Profile wide(3.0, -0.6, 1.5, 0.0);
    EXPECT_TRUE(find_curvature_joints(wide.breaks, wide.slope, wide.length, 1e-6).empty());
    const Profile hidden(3.0, -0.6, 0.15, 0.0);
    EXPECT_TRUE(find_curvature_joints(hidden.breaks, hidden.slope, hidden.length, 1e-2).empty()) << "in the noise";
}

/// Where the slope ends there may be a jump all the same: the curve does not tell it from the slope.
TEST(CurvatureJoints, AreSupposedWhereASlopeEnds) {
    const Profile ends(3.0, 0.0, 0.1, -0.5);
    std::vector<CurvatureJoint> joints;
    add_supposed_joints(ends.breaks, ends.slope, ends.length, 1e-5, joints);
    ASSERT_EQ(joints.size(), 1U);
    EXPECT_TRUE(joints[0].supposed);
    EXPECT_NEAR(joints[0].t, 3.0, 0.15);
    EXPECT_LT(joints[0].step, 0.0);
    add_supposed_joints(ends.breaks, ends.slope, ends.length, 1e-5, joints);
    EXPECT_EQ(joints.size(), 1U) << "one is there already";
    joints.clear();
    add_supposed_joints(ends.breaks, ends.slope, ends.length, 1e-2, joints);
    EXPECT_TRUE(joints.empty()) << "in the noise";
}

/// A ramp beside such an end that shows little of its step, or runs the other way, is noise on the slope.
TEST(CurvatureJoints, AreAtTheEndOfASlopeRatherThanOnALittleRamp) {
    const Profile ends(3.0, 0.0, 0.1, -0.5);
    std::vector<CurvatureJoint> joints;
    add_supposed_joints(ends.breaks, ends.slope, ends.length, 1e-5, joints);
    ASSERT_EQ(joints.size(), 1U);
    const CurvatureJoint end = joints[0];
    for (const double share : {-2.0, -0.9, 0.4, 0.6, 2.0}) {
        CurvatureJoint ramp = end;
        ramp.supposed = false;
        ramp.t = end.t + 0.3;
        ramp.step = share * end.step;
        joints = {ramp};
        add_supposed_joints(ends.breaks, ends.slope, ends.length, 1e-5, joints);
        ASSERT_EQ(joints.size(), 1U) << share;
        const bool stays = share == -2.0 || share >= 0.6;
        EXPECT_EQ(joints[0].supposed, !stays) << share;
        EXPECT_EQ(joints[0].t, stays ? ramp.t : end.t) << share;
    }
}

/// Of the four joints of a wide fan blade, whose edges are ellipses; and nowhere else.
TEST(CurvatureJoints, AreFoundWhereEllipsesEnd) {
    std::size_t known = 0, all = 0, elsewhere = 0;
    for (std::uint64_t k = 0; k < 12; ++k) {
        const auto blade = families::make(families::Family::fan, 9000 + k);
        families::ScanOptions scanning;
        scanning.seed = k + 1;
        scanning.sigma_mm = 1e-3;
        scanning.bad_share = 0.0;
        const auto smooth = smooth_closed(families::scan(blade, scanning).points);
        ASSERT_TRUE(smooth);
        std::vector<char> found(4, 0);
        for (const CurvatureStep& joint : smooth->joints) {
            const Vec2 at = smooth->curve.jet(joint.t).position;
            bool near = false;
            for (int corner = 0; corner < 4; ++corner)
                if ((at - blade.ball_centre(corner, scanning.ball_mm)).norm() < 0.5) {
                    near = true;
                    found[static_cast<std::size_t>(corner)] = 1;
                }
            elsewhere += static_cast<std::size_t>(!near && std::abs(joint.step) > 0.05);
        }
        known += static_cast<std::size_t>(std::count(found.begin(), found.end(), 1));
        all += 4;
    }
    std::cout << "found " << known << " of " << all << ", elsewhere " << elsewhere << "\n";
    EXPECT_GE(known, all - 3) << "6 are missed where ramps alone are looked for";
    EXPECT_LE(elsewhere, 3U);
}

/// What made the ramp of a joint is no roughness of the side beside it.
TEST(CurvatureJoints, LeaveTheSidesAsSmoothAsTheyAre) {
    constexpr std::size_t blades = 40;
    double largest_um = 0.0;
    std::size_t above = 0;
    for (std::uint64_t k = 0; k < blades; ++k) {
        const auto blade = families::make(families::Family::fan, 9100 + k);
        families::ScanOptions scanning;
        scanning.seed = k + 1;
        scanning.sigma_mm = 1e-3;
        scanning.bad_share = 0.0;
        SectionOptions options;
        options.ball_radius_mm = scanning.ball_mm;
        options.le_hint = blade.le().nose;
        options.te_hint = blade.te().nose;
        const auto fit = fit_section(families::scan(blade, scanning).points, {}, options);
        ASSERT_TRUE(fit);
        double largest = 0.0;
        for (const ContourPoint& p : fit->contour) {
            const auto foot = blade.closest(p.position_mm);
            const auto part = families::Blade::part_of(foot.t);
            if (part == families::Part::le || part == families::Part::te) continue;
            largest = std::max(largest, 1e3 * std::abs(foot.distance));
        }
        largest_um += largest / double(blades);
        above += std::size_t(largest > 2.0);
    }
    std::cout << "largest " << largest_um << " um (mean), " << above << " above 2 um\n";
    EXPECT_LT(largest_um, 0.97) << "it was 1.50, and 1.04 before edges told where they end";
    EXPECT_LE(above, 1U) << "it was 9";
}

TEST(CurvatureJoints, GetThreeKnotsInPlaceOfTheNearest) {
    const Profile profile(3.0, -0.6, 0.15, 0.0);
    const std::vector<double> places{1.01, 3.05};
    std::vector<KnotCluster> at;
    const auto breaks = breaks_with_joints(profile.breaks, places, 3, 0.02, at);
    ASSERT_EQ(at.size(), 2U);
    EXPECT_EQ(breaks.size(), profile.breaks.size() + 2U + 3U) << "the knot at 1.0 is gone";
    EXPECT_TRUE(std::is_sorted(breaks.begin(), breaks.end(), std::less_equal<>()));
    for (std::size_t j = 0; j < 2; ++j) {
        EXPECT_DOUBLE_EQ(breaks[at[j].first + 1], places[j]);
        EXPECT_NEAR(breaks[at[j].first + 2] - places[j], 0.002, 1e-12);
        EXPECT_NEAR(at[j].apart, 0.002, 1e-12);
    }
    EXPECT_EQ(breaks.front(), profile.breaks.front());
    EXPECT_EQ(breaks.back(), profile.breaks.back());
}

/// Two semicircles of radius 1 and 5 mm joined by straight lines that touch both: the curvature jumps four times.
struct Slot {
    double far = 30.0, small = 1.0, large = 5.0;
    double tilt = std::asin((large - small) / far);

    double length(int part) const {
        if (part == 0) return large * (pi + 2.0 * tilt);
        return part == 2 ? small * (pi - 2.0 * tilt) : far * std::cos(tilt);
    }
    double whole() const { return length(0) + length(1) + length(2) + length(3); }
    /// From the middle of the large arc on: the curve's first place is none of its joints.
    Vec2 at(double from_middle) const {
        double s = std::fmod(from_middle + 0.5 * length(0), whole());
        int part = 0;
        for (; part < 3 && s > length(part); ++part)
            s -= length(part);
        const double upper = 0.5 * pi - tilt;  // direction in which the upper line touches
        if (part == 0) return large * Vec2(std::cos(upper + s / large), std::sin(upper + s / large));
        const double below = -upper;
        if (part == 1) return large * Vec2(std::cos(below), std::sin(below)) + s * Vec2(std::cos(tilt), std::sin(tilt));
        if (part == 2) return Vec2(far, 0.0) + small * Vec2(std::cos(below + s / small), std::sin(below + s / small));
        return Vec2(far, 0.0) + small * Vec2(std::cos(upper), std::sin(upper)) +
               s * Vec2(-std::cos(tilt), std::sin(tilt));
    }
    double distance(const Vec2& p) const {
        double least = 1e9;
        const auto to = [&](const Vec2& centre, double radius) { return std::abs((p - centre).norm() - radius); };
        const double upper = 0.5 * pi - tilt;
        const Vec2 up(std::cos(upper), std::sin(upper)), mirrored(p.x(), std::abs(p.y()));
        const double along = mirrored.dot(Vec2(std::cos(tilt), -std::sin(tilt)));
        const double begin = (large * up).dot(Vec2(std::cos(tilt), -std::sin(tilt)));
        if (along < begin)
            least = to(Vec2::Zero(), large);
        else if (along > begin + length(1))
            least = to(Vec2(far, 0.0), small);
        else
            least = std::abs(mirrored.dot(up) - large);
        return least;
    }
};

struct Error {
    double rms_um = 0.0, largest_um = 0.0;
};

Error slot_error(double sigma_mm, int scans) {
    const Slot slot;
    Error error;
    for (int scan = 0; scan < scans; ++scan) {
        std::mt19937 random(static_cast<unsigned>(7 + scan));
        std::normal_distribution<double> noise(0.0, sigma_mm);
        std::uniform_real_distribution<double> jitter(0.0, 1.0);
        std::vector<Vec2> points;
        // Sparse on the lines: a joint lies between two points far from each other.
        const double lower = 0.5 * slot.length(0), right = lower + slot.length(1);
        for (double s = 0.05; s<slot.whole() - 0.05; s += s> lower && s < right ? 0.5 : 0.1) {
            const double place = s + 0.02 * jitter(random);
            const Vec2 tangent = (slot.at(place + 1e-6) - slot.at(place - 1e-6)).normalized();
            points.push_back(slot.at(place) + noise(random) * right_normal(tangent));
        }
        const auto smooth = smooth_closed(points);
        EXPECT_TRUE(smooth);
        if (!smooth) return error;
        double largest = 0.0;
        constexpr int places = 6000;
        for (int i = 0; i < places; ++i) {
            const double t = smooth->curve.front() + smooth->curve.period() * i / places;
            const double off = 1e3 * slot.distance(smooth->curve.jet(t).position);
            error.rms_um += off * off / (places * scans);
            largest = std::max(largest, off);
        }
        error.largest_um += largest / scans;
    }
    error.rms_um = std::sqrt(error.rms_um);
    std::cout << 1e3 * sigma_mm << " um: rms " << error.rms_um << ", largest " << error.largest_um << " um\n";
    return error;
}

TEST(CurvatureJoints, LetTheCurveFollowArcsAndLines) {
    const Error exact = slot_error(0.0, 4);
    EXPECT_LT(exact.rms_um, 0.02) << "0.058 without joints";
    EXPECT_LT(exact.largest_um, 0.25) << "1.39";
    const Error noisy = slot_error(1e-3, 12);
    EXPECT_LT(noisy.rms_um, 0.3);
    EXPECT_LT(noisy.largest_um, 1.5);
}

}  // namespace
}  // namespace cmm::fitting
