// SPDX-License-Identifier: Apache-2.0
#include "acquisition/unknown_scan.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <optional>

#include "acquisition/clearance.hpp"
#include "acquisition/nominal_kinds.hpp"
#include "core/rng.hpp"
#include "tests/acquisition/test_blade.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// A machine that keeps the ball on a polygon: at every path point it goes along the normal until the ball touches.
struct Servo {
    std::vector<Vector2d> part;
    double radius_mm = 1.0, search_mm = 1.5;

    double gap(const Vector2d& p) const { return distance_to_outline(p, part) - radius_mm; }
    std::optional<Vector2d> contact(const drivers::PathPoint& at) const {
        const Vector2d from = at.centre_mm.head<2>(), normal = at.normal.head<2>();
        const bool starts_free = gap(from) > 0.0;
        const Vector2d way = starts_free ? Vector2d(-normal) : normal;
        double s = 0.0;
        while (s <= search_mm) {
            const double room = gap(from + s * way);
            if (starts_free && room < 1e-6) return from + s * way;
            if (!starts_free && room >= 0.0) break;
            s += std::max(std::abs(room), 1e-7);
        }
        if (starts_free || s > search_mm) return std::nullopt;
        return from + s * way;
    }
};

struct Disturbance {
    double noise_mm = 1e-3, bad_share = 0.01;
    std::uint64_t seed = 1;
};

struct Lap {
    bool closed = false;
    std::string error;
    std::size_t points = 0, no_contact = 0, bad = 0;
    std::vector<Vector2d> centres;
    std::vector<double> speeds;
};

/// Runs the scan in lock-step, as a machine does.
Lap run(const Servo& servo, const UnknownScanOptions& options, const Vector3d& touch, const Vector2d& outward,
        const Disturbance& disturbance) {
    UnknownScan scan(options, touch, outward);
    core::Rng rng(disturbance.seed);
    Lap lap;
    std::size_t bad_run = 0;
    double bad_mm = 0.0;
    for (bool last = false; !last && lap.points < 20000;) {
        std::array<drivers::PathPoint, 4> room;
        const std::size_t n = scan.next(room, last);  // strictly one at a time
        if (n == 0) break;
        EXPECT_EQ(n, 1U);
        bool early = false;
        std::array<drivers::PathPoint, 4> more;
        EXPECT_EQ(scan.next(more, early), 0U);
        ++lap.points;
        const auto contact = servo.contact(room[0]);
        Vector2d centre =
            contact.value_or(Vector2d(room[0].centre_mm.head<2>() - servo.search_mm * room[0].normal.head<2>()));
        if (contact) {
            lap.centres.push_back(centre);
            lap.speeds.push_back(room[0].speed_mm_s);
            const Vector2d normal = room[0].normal.head<2>();
            if (bad_run == 0 && rng.uniform() < disturbance.bad_share) {
                bad_run = 1 + rng.below(3);
                bad_mm = rng.uniform(0.02, 0.4) * (rng.uniform() < 0.5 ? -1.0 : 1.0);
            }
            centre += disturbance.noise_mm * rng.normal() * normal;
            if (bad_run > 0) {
                centre += bad_mm * normal;
                --bad_run;
                ++lap.bad;
            }
        } else {
            ++lap.no_contact;
        }
        const auto status = scan.on_sample({centre.x(), centre.y(), touch.z()}, !contact);
        if (!status) {
            lap.error = status.error().message;
            break;
        }
    }
    lap.closed = scan.closed();
    return lap;
}

/// Goes round from the middle of the upper side; checks that the lap is complete and dense enough.
Lap check_lap(const std::vector<Vector2d>& part, double radius, const Disturbance& disturbance,
              double touch_error_rad = 0.0) {
    Servo servo{part, radius, 1.5};
    Vector2d middle = Vector2d::Zero();
    for (const auto& p : part)
        middle += p / static_cast<double>(part.size());
    // Down along y from outside, as a first touch does.
    drivers::PathPoint from;
    from.centre_mm = {middle.x(), middle.y() + 40.0, 7.0};
    from.normal = Vector3d::UnitY();
    servo.search_mm = 80.0;
    const auto touch = servo.contact(from);
    EXPECT_TRUE(touch);
    servo.search_mm = 1.5;
    UnknownScanOptions options;
    options.ball_radius_mm = radius;
    const Vector2d outward = Eigen::Rotation2Dd(touch_error_rad) * Vector2d::UnitY();
    const auto lap = run(servo, options, {touch->x(), touch->y(), 7.0}, outward, disturbance);
    EXPECT_TRUE(lap.closed) << lap.error << " after " << lap.points << " points, bad " << lap.bad << ", seed "
                            << disturbance.seed << ", r " << radius;
    EXPECT_EQ(lap.error, "");
    // Every place of the part had the ball near it.
    const auto& c = lap.centres;
    for (std::size_t i = 0; i < part.size(); i += 5) {
        double nearest = 1e9;
        for (const auto& p : c)
            nearest = std::min(nearest, (p - part[i]).norm());
        EXPECT_LT(nearest, radius + 0.3) << part[i].transpose();
    }
    for (std::size_t i = 1; i < c.size(); ++i)
        EXPECT_LT((c[i] - c[i - 1]).norm(), 1.2);  // the ball jumps over a dent
    EXPECT_LT(lap.points, 1500U);
    return lap;
}

std::vector<Vector2d> blade_outline(double le, double te, double thickness = 3.0, double camber_deg = 30.0) {
    auto blade = test_blade();
    blade.le_radius_mm = le;
    blade.te_radius_mm = te;
    blade.thickness_root_mm = blade.thickness_tip_mm = thickness;
    blade.camber_rad = camber_deg * std::numbers::pi / 180.0;
    return parametric_nominal(blade).value()->cut(30.0)->points;
}

TEST(UnknownScan, GoesRoundASharpTrailingEdgeWithAnyBall) {
    const auto part = blade_outline(0.4, 0.1);
    for (const double radius : {0.25, 0.5, 1.0, 2.0}) {
        const auto clean = check_lap(part, radius, {0.0, 0.0, 1});
        EXPECT_LE(clean.no_contact, 6U) << radius;
        for (std::uint64_t seed = 1; seed <= 8; ++seed)
            check_lap(part, radius, {1e-3, 0.01, seed});
    }
}

TEST(UnknownScan, GoesRoundThickConcaveAndBluntBlades) {
    for (const auto& part :
         {blade_outline(2.0, 2.0, 6.0), blade_outline(1.0, 0.2, 5.0, 80.0), blade_outline(0.3, 0.1, 1.2, 10.0)}) {
        for (const double radius : {0.25, 1.0, 2.0}) {
            for (std::uint64_t seed = 11; seed <= 14; ++seed)
                check_lap(part, radius, {1e-3, 0.01, seed});
        }
    }
}

TEST(UnknownScan, CopesWithManyBadPointsAndACrookedFirstTouch) {
    const auto part = blade_outline(0.5, 0.2);
    for (std::uint64_t seed = 21; seed <= 26; ++seed) {
        const auto lap = check_lap(part, 1.0, {2e-3, 0.04, seed});
        EXPECT_GT(lap.bad, 5U);
        check_lap(part, 0.5, {1e-3, 0.01, seed}, 0.6);
        check_lap(part, 0.5, {1e-3, 0.01, seed}, -0.6);
    }
}

TEST(UnknownScan, IsDenserAndSlowerAtTheEdges) {
    const auto part = blade_outline(0.5, 0.5);
    const auto lap = check_lap(part, 1.0, {1e-3, 0.0, 3});
    const auto [slow, fast] = std::minmax_element(lap.speeds.begin(), lap.speeds.end());
    EXPECT_LE(*slow, 3.0);
    EXPECT_GE(*fast, 9.0);
    double widest = 0.0;
    for (std::size_t i = 1; i < lap.centres.size(); ++i)
        widest = std::max(widest, (lap.centres[i] - lap.centres[i - 1]).norm());
    EXPECT_GT(widest, 0.3);
    EXPECT_GT(lap.points, 150U);
    EXPECT_LT(lap.points, 500U);
    // Past the start by three points, and no lap more.
    const auto& c = lap.centres;
    EXPECT_LT((c.back() - c.front()).norm(), 2.0);
}

TEST(UnknownScan, GoesRoundTheMeshedEngineBlade) {
    const std::string file = real_data("engine-blade/engine-blade.ply");
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    NominalSpec spec;
    spec.kind = NominalKind::mesh;
    spec.files = {file};
    const auto nominal = load_nominal(spec).value();
    for (const double z : {300.0, 335.0, 370.0}) {
        const auto part = nominal->cut(z)->points;
        for (const double radius : {0.5, 1.0})
            check_lap(part, radius, {1e-3, 0.01, static_cast<std::uint64_t>(z)});
    }
}

TEST(UnknownScan, GivesUpWhenTheSurfaceEnds) {
    // Nothing but a thin plate far wider than the box says: the path never closes in time.
    const std::vector<Vector2d> plate{{-500, -1}, {500, -1}, {500, 1}, {-500, 1}};
    UnknownScanOptions options;
    options.longest_mm = 60.0;
    const auto far = run({plate, 1.0, 1.5}, options, {0, 2, 0}, Vector2d::UnitY(), {0.0, 0.0, 1});
    EXPECT_FALSE(far.closed);
    EXPECT_NE(far.error.find("does not close"), std::string::npos) << far.error;
    // Nothing under the ball at all.
    const std::vector<Vector2d> elsewhere{{50, 50}, {60, 50}, {60, 60}};
    const auto lost = run({elsewhere, 1.0, 1.5}, options, {0, 2, 0}, Vector2d::UnitY(), {0.0, 0.0, 1});
    EXPECT_NE(lost.error.find("the surface was lost"), std::string::npos) << lost.error;
    EXPECT_LT(lost.points, 100U);
}

TEST(UnknownScan, TakesItsOptionsFromThePartFile) {
    PartFile part;
    part.stylus.radius_mm = 0.5;
    part.scan.box_mm = std::array<double, 4>{0.0, 0.0, 30.0, 10.0};
    const auto options = unknown_scan_options(part);
    EXPECT_DOUBLE_EQ(options.longest_mm, 320.0);
    EXPECT_DOUBLE_EQ(options.ball_radius_mm, 0.5);
}

}  // namespace
}  // namespace cmm::acquisition
