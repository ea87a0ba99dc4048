// SPDX-License-Identifier: Apache-2.0
#include "acquisition/plan.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "acquisition/clearance.hpp"
#include "acquisition/nominal_kinds.hpp"
#include "acquisition/plan_check.hpp"
#include "core/text.hpp"
#include "tests/acquisition/test_blade.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Job {
    PartFile part;
    std::shared_ptr<const Nominal> nominal;
};

Job blade_job(const ParametricBlade& blade = test_blade()) {
    Job job;
    job.part.name = "test";
    job.part.nominal.kind = NominalKind::parametric;
    job.part.nominal.blade = blade;
    job.part.scan.heights_mm = {10.0, 30.0, 50.0};
    job.nominal = parametric_nominal(blade).value();
    return job;
}

Plan planned(const Job& job) {
    auto plan = make_plan(job.part, job.nominal.get());
    EXPECT_TRUE(plan) << plan.error().text();
    return plan.value_or(Plan{});
}

std::vector<Vector2d> outline(const Job& job, double z) {
    return job.nominal->cut(z)->points;
}

TEST(Plan, RunsTheBallRoundTheNominalAndOverItsStart) {
    const auto job = blade_job();
    const auto plan = planned(job);
    ASSERT_EQ(plan.paths.size(), 3U);
    for (const auto& path : plan.paths) {
        const auto nominal = outline(job, path.z_mm);
        double turned = 0.0;
        for (std::size_t i = 0; i < path.points.size(); ++i) {
            const auto& p = path.points[i];
            EXPECT_NEAR(distance_to_polygon(p.centre_mm.head<2>(), nominal), 1.0, 1e-3);
            EXPECT_NEAR(p.normal.norm(), 1.0, 1e-9);
            EXPECT_DOUBLE_EQ(p.centre_mm.z(), path.z_mm);
            EXPECT_TRUE(p.record);
            EXPECT_LE(p.speed_mm_s, job.part.scan.max_speed_mm_s);
            // The contact lies under the ball along the normal.
            EXPECT_LT(distance_to_polygon((p.centre_mm - p.normal).head<2>(), nominal), 1e-3);
            if (i == 0) continue;
            const Vector2d a = path.points[i - 1].normal.head<2>(), b = p.normal.head<2>();
            turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
        }
        EXPECT_GT(turned, 2.0 * std::numbers::pi);
        EXPECT_LT(turned, 2.0 * std::numbers::pi + 0.2);
        const std::size_t n = path.points.size();
        for (std::size_t k = 0; k < 4; ++k)
            EXPECT_EQ(path.points[k].centre_mm, path.points[n - 4 + k].centre_mm);
        // The suction side of a blade at positive stagger looks up and to the left.
        EXPECT_GT(path.points[0].normal.y(), 0.5);
        const auto [le, te] = std::minmax_element(nominal.begin(), nominal.end(),
                                                  [](const auto& a, const auto& b) { return a.x() < b.x(); });
        EXPECT_NEAR(path.points[0].centre_mm.x(), 0.5 * (le->x() + te->x()), 0.25 * (te->x() - le->x()));
    }
}

TEST(Plan, IsDenseAtTheEdgesAndChangesItsStepSmoothly) {
    auto job = blade_job();
    job.part.scan.pitch_mm = 0.8;
    job.part.scan.edge_density = 8.0;
    const auto plan = planned(job);
    const auto& points = plan.paths[1].points;
    std::vector<double> step;
    for (std::size_t i = 1; i < points.size(); ++i)
        step.push_back((points[i].centre_mm - points[i - 1].centre_mm).norm());
    EXPECT_NEAR(*std::min_element(step.begin(), step.end()), 0.1, 0.01);
    EXPECT_LE(*std::max_element(step.begin(), step.end()), 0.81);
    EXPECT_GE(*std::max_element(step.begin(), step.end()), 0.5);
    for (std::size_t i = 1; i < step.size(); ++i)
        EXPECT_LT(std::abs(step[i] / step[i - 1] - 1.0), 0.35) << i;
    const auto by_x = [](const auto& a, const auto& b) { return a.centre_mm.x() < b.centre_mm.x(); };
    for (const auto& edge :
         {std::min_element(points.begin(), points.end(), by_x), std::max_element(points.begin(), points.end(), by_x)}) {
        const auto i = static_cast<std::size_t>(edge - points.begin());
        EXPECT_NEAR(step[i], 0.1, 0.02);
        EXPECT_LT(edge->speed_mm_s, 0.2 * job.part.scan.max_speed_mm_s);
    }
}

TEST(Plan, TravelsWithoutCuttingThePart) {
    const auto job = blade_job();
    const auto plan = planned(job);
    for (std::size_t k = 0; k < plan.paths.size(); ++k) {
        const auto& path = plan.paths[k];
        ASSERT_FALSE(path.approach_route.empty());
        EXPECT_LT((path.approach_route.back() - above(path.points[0], 1.0)).norm(), 1e-9);
        Vector3d from = k == 0 ? path.approach_route.front() : above(plan.paths[k - 1].points.back(), 1.0);
        for (const auto& to : path.approach_route) {
            for (int i = 0; i <= 100; ++i) {
                const Vector3d p = from + (to - from) * (i / 100.0);
                if (p.z() < 0.0 || p.z() > 60.0) continue;
                EXPECT_GT(distance_to_outline(p.head<2>(), outline(job, p.z())), 1.2) << k;
            }
            from = to;
        }
    }
    // From anywhere outside to a path and back, also over the top.
    for (const Vector3d& home : {Vector3d(0, 0, 200), Vector3d(-300, 40, -20), Vector3d(5, 100, 30)}) {
        const auto to = above(plan.paths[1].points[0], 1.0);
        const auto route = travel_route(plan, home, to);
        ASSERT_FALSE(route.empty());
        EXPECT_EQ(route.back(), to);
        EXPECT_EQ(travel_route(plan, to, home).back(), home);
    }
}

TEST(Plan, BridgesConcavePlacesThatAreTooTight) {
    // A disc of radius 10 with a dent whose smallest concave radius is about 1.1 mm.
    std::vector<Vector2d> points;
    for (int i = 0; i < 4000; ++i) {
        const double a = 2.0 * std::numbers::pi * i / 4000.0 - std::numbers::pi;
        points.emplace_back((10.0 - 1.5 * std::exp(-(a / 0.2) * (a / 0.2))) * Vector2d(std::cos(a), std::sin(a)));
    }
    const auto curve = fitting::ClosedCurve::through(points);
    ASSERT_TRUE(curve);
    EXPECT_TRUE(ball_path(*curve, 0.5).unreached.empty());
    const auto wide = ball_path(*curve, 3.0);
    ASSERT_EQ(wide.unreached.size(), 1U);
    EXPECT_NEAR(wide.unreached[0].position_mm.y(), 0.0, 1.0);
    EXPECT_GT(wide.unreached[0].depth_mm, 0.1);
    for (const auto& p : wide.points)
        EXPECT_NEAR(distance_to_polygon(p.centre_mm, points), 3.0, 2e-3);
}

TEST(Plan, HasAFileFormThatKeepsItsHash) {
    const auto job = blade_job();
    const auto plan = planned(job);
    const auto text = plan_to_text(plan);
    const auto again = parse_plan(text, "p.json");
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(again->hash, plan.hash);
    EXPECT_EQ(plan_to_text(*again), text);
    EXPECT_EQ(again->paths[2].points.size(), plan.paths[2].points.size());
    EXPECT_NEAR((again->paths[2].points[5].centre_mm - plan.paths[2].points[5].centre_mm).norm(), 0.0, 1e-8);
    EXPECT_EQ(planned(job).hash, plan.hash);
    auto other = blade_job();
    other.part.scan.pitch_mm = 0.41;
    EXPECT_NE(planned(other).hash, plan.hash);
    auto forged = text;
    forged.replace(forged.find("\"z_mm\": 30.0"), 12, "\"z_mm\": 31.0");
    EXPECT_NE(parse_plan(forged, "p.json").error().message.find("the hash does not fit"), std::string::npos);
    EXPECT_EQ(parse_plan("{", "p.json").error().code, core::ErrorCode::config_syntax);
    EXPECT_EQ(parse_plan("{}", "p.json").error().message, "p.json: not a plan of cmmlive");
    EXPECT_EQ(parse_plan("{\"schema\": \"cmmlive-plan\", \"schema_version\": 1}", "p.json").error().code,
              core::ErrorCode::config_invalid);
}

TEST(Plan, OfAnUnknownPartHasHeightsAndFirstTouches) {
    Job job;
    job.part.name = "u";
    job.part.scan.heights_mm = {5.0, 9.0};
    job.part.scan.box_mm = std::array<double, 4>{-20.0, -5.0, 20.0, 7.0};
    const auto plan = planned(job);
    ASSERT_EQ(plan.paths.size(), 2U);
    EXPECT_TRUE(plan.paths[0].points.empty());
    EXPECT_EQ(*plan.paths[0].start_mm, Vector2d(0.0, -11.0));  // across the longer side, clearance and ball outside
    EXPECT_EQ(*plan.paths[0].toward_mm, Vector2d(0.0, 1.0));
    // After a section the probe is near its start and leaves the way it came.
    const auto route = travel_route(plan, {0.3, -3.0, 5.0}, {0.0, -11.0, 9.0});
    ASSERT_GE(route.size(), 2U);
    EXPECT_NEAR((route[0] - Vector3d(0.3, -11.0, 5.0)).norm(), 0.0, 1e-9);
    EXPECT_TRUE(require_sound(check_plan(plan, job.part, nullptr)));
    const auto again = parse_plan(plan_to_text(plan), "u.json");
    ASSERT_TRUE(again);
    EXPECT_EQ(*again->paths[1].toward_mm, *plan.paths[1].toward_mm);
    job.part.scan.box_mm.reset();
    EXPECT_EQ(make_plan(job.part, nullptr).error().code, core::ErrorCode::plan_invalid);
}

TEST(Plan, RefusesHeightsOutsideTheNominal) {
    auto job = blade_job();
    job.part.scan.heights_mm = {30.0, 70.0};
    const auto plan = make_plan(job.part, job.nominal.get());
    ASSERT_FALSE(plan);
    EXPECT_EQ(plan.error().code, core::ErrorCode::plan_invalid);
}

std::string findings_text(const std::vector<Finding>& findings, Severity severity) {
    std::string text;
    for (const auto& finding : findings)
        text += finding.severity == severity ? finding.text + "\n" : "";
    return text;
}

TEST(PlanCheck, FindsTravelLimitsShankAndSampleClock) {
    const auto job = blade_job();
    drivers::Capabilities machine;
    machine.limit_min_mm = {-100, -100, 0};
    machine.limit_max_mm = {100, 100, 45};
    machine.max_speed_mm_s = 100.0;
    machine.sample_rate_hz = 20.0;
    const auto plan = make_plan(job.part, job.nominal.get(), &machine);
    ASSERT_TRUE(plan);
    const auto findings = check_plan(*plan, job.part, job.nominal.get(), &machine);
    const auto errors = findings_text(findings, Severity::error), warnings = findings_text(findings, Severity::warning);
    EXPECT_NE(
        errors.find("section 2 (z 50.000 mm): z = 50.000 mm lies outside the machine's travel (0.000 mm to 45.000 mm)"),
        std::string::npos)
        << errors;
    EXPECT_EQ(errors.find("section 0"), std::string::npos) << errors;
    EXPECT_NE(warnings.find("section 0 (z 10.000 mm): a shank that hangs straight down would enter the part"),
              std::string::npos)
        << warnings;
    EXPECT_NE(warnings.find("faster than the machine's sample clock"), std::string::npos);
    EXPECT_NE(findings_text(findings, Severity::note).find("3 sections"), std::string::npos);
    const auto status = require_sound(findings);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, core::ErrorCode::plan_invalid);
}

TEST(PlanCheck, TheDeepestOfAllShanksIsNamed) {
    auto job = blade_job();
    job.part.scan.heights_mm = {10.0};
    job.part.scan.pitch_mm = 0.05;
    const auto plan = planned(job);
    double depth = 0.0;
    for (const auto& obstacle : plan.clearance.obstacles) {
        const double rise = obstacle.z_mm - 10.0;
        if (rise <= job.part.stylus.radius_mm || rise > job.part.stylus.length_mm) continue;
        for (const auto& point : plan.paths[0].points) {
            const double inside = -distance_to_outline(point.centre_mm.head<2>(), obstacle.outline);
            depth = std::max(depth, job.part.stylus.shank_radius_mm + inside);
        }
    }
    ASSERT_GT(depth, 0.0);
    const auto warnings = findings_text(check_plan(plan, job.part, job.nominal.get()), Severity::warning);
    EXPECT_NE(warnings.find("would enter the part by " + core::length_text(depth) + " at"), std::string::npos)
        << depth << "\n"
        << warnings;
}

TEST(PlanCheck, FindsNothingToStopAPrismFor) {
    auto blade = test_blade();
    blade.chord_tip_mm = blade.chord_root_mm;
    blade.thickness_tip_mm = blade.thickness_root_mm;
    blade.stagger_tip_rad = blade.stagger_root_rad;
    blade.lean_x_rad = blade.lean_y_rad = 0.0;
    const auto job = blade_job(blade);
    const auto findings = check_plan(planned(job), job.part, job.nominal.get());
    EXPECT_EQ(findings_text(findings, Severity::error), "");
    EXPECT_EQ(findings_text(findings, Severity::warning), "");
    EXPECT_TRUE(require_sound(findings));
}

TEST(PlanCheck, FindsATravelThatCutsThePart) {
    const auto job = blade_job();
    auto plan = planned(job);
    const auto& points = plan.paths[1].points;
    plan.paths[1].approach_route = {above(points[points.size() / 2], 1.0), above(points[0], 1.0)};  // straight through
    EXPECT_NE(findings_text(check_plan(plan, job.part, job.nominal.get()), Severity::error)
                  .find("the travel to its first point cuts the part"),
              std::string::npos);
}

/// A horseshoe, 2 mm thick, round a hollow of 6 mm, its ends 2.5 mm apart; upright.
std::shared_ptr<const Nominal> horseshoe() {
    constexpr double pi = std::numbers::pi, middle_mm = 4.0, opening = 0.57;
    const auto at = [](double radius, double angle) {
        return Vector2d(radius * std::cos(angle), radius * std::sin(angle));
    };
    std::vector<Vector2d> points;
    const auto arc = [&](const Vector2d& centre, double radius, double from, double turn) {
        const int steps = static_cast<int>(radius * std::abs(turn) / 0.05);
        for (int i = 0; i < steps; ++i)
            points.push_back(centre + at(radius, from + turn * i / steps));
    };
    const double bend = 2.0 * pi - 2.0 * opening;
    arc(Vector2d::Zero(), middle_mm + 1.0, opening, bend);
    arc(at(middle_mm, -opening), 1.0, -opening, pi);
    arc(Vector2d::Zero(), middle_mm - 1.0, -opening, -bend);
    arc(at(middle_mm, opening), 1.0, opening + pi, pi);
    std::vector<PointSection> sections(2);
    for (std::size_t k = 0; k < sections.size(); ++k) {
        for (const auto& p : points)
            sections[k].points_mm.emplace_back(p.x(), p.y(), 40.0 * static_cast<double>(k));
    }
    return sections_nominal(sections, Span::z).value();
}

TEST(PlanCheck, FindsATouchWhoseWayIsTooNarrow) {
    Job job;
    job.part.scan.heights_mm = {10.0};
    job.part.stylus.radius_mm = 0.8;
    job.nominal = horseshoe();
    const auto errors = [&](double approach_mm, bool by_touches) {
        job.part.scan.approach_mm = approach_mm;
        return findings_text(check_plan(planned(job), job.part, job.nominal.get(), nullptr, by_touches),
                             Severity::error);
    };
    const std::string finding = "leads too close to the part; a smaller [scan] approach_mm helps";
    const auto blocked = errors(1.0, true);
    EXPECT_NE(blocked.find("section 0 (z 10.000 mm): the way to the touch at x "), std::string::npos) << blocked;
    EXPECT_NE(blocked.find(finding), std::string::npos) << blocked;
    EXPECT_EQ(errors(0.3, true).find(finding), std::string::npos);
    EXPECT_EQ(errors(1.0, false).find(finding), std::string::npos);  // a scan takes no such ways
}

TEST(Plan, OfTheEngineBladeFollowsItsMesh) {
    const std::string file = real_data("engine-blade/engine-blade.ply");
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    Job job;
    job.part.nominal.kind = NominalKind::mesh;
    job.part.nominal.files = {file};
    job.part.scan.heights_mm = {300.0, 335.0, 370.0};
    job.nominal = load_nominal(job.part.nominal).value();
    const auto plan = planned(job);
    for (const auto& path : plan.paths) {
        const auto nominal = outline(job, path.z_mm);
        for (const auto& p : path.points)
            EXPECT_NEAR(distance_to_polygon(p.centre_mm.head<2>(), nominal), 1.0,
                        8e-3);  // a spline rounds facet corners
        EXPECT_GT(path.points.size(), 100U);
        EXPECT_LT(path.points.size(), 1500U);
    }
    EXPECT_EQ(findings_text(check_plan(plan, job.part, job.nominal.get()), Severity::error), "");
}

}  // namespace
}  // namespace cmm::acquisition
