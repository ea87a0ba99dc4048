// SPDX-License-Identifier: Apache-2.0
/// Six datum points in a part file, on the nominal, and in a plan.
#include "acquisition/six_point_spec.hpp"

#include <gtest/gtest.h>

#include "acquisition/datum_touches.hpp"
#include "acquisition/plan_check.hpp"
#include "tests/acquisition/six_point_blade.hpp"

namespace cmm::acquisition {
namespace {

std::string with_alignment(const std::string& table) {
    return session_part_text() + table;
}

std::string read_error(const std::string& table) {
    const auto part = parse_part_file(with_alignment(table), "p.toml");
    if (part) return "read";
    EXPECT_EQ(part.error().code, core::ErrorCode::config_invalid);
    return part.error().message;
}

std::string six(const std::array<const char*, 6>& places, const std::array<const char*, 6>& directions,
                const std::string& more = "") {
    std::string table = "[alignment]\nkind = \"rps\"\n" + more;
    for (std::size_t i = 0; i < 6; ++i)
        table += std::string("[[alignment.point]]\nat_mm = ") + places[i] + "\ndirection = " + directions[i] + "\n";
    return table;
}

constexpr std::array places{"[0, 0, 60]", "[10, 0, 60]", "[0, 8, 60]", "[0, -9, 5]", "[20, -9, 5]", "[-15, 0, 5]"};
constexpr std::array directions{"[0, 0, 1]", "[0, 0, 3]", "[0, 0, 1]", "[0, -1, 0]", "[0, -1, 0]", "[-2, 0, 0]"};

TEST(SixPointSpec, IsReadWithItsDefaults) {
    const auto part = parse_part_file(with_alignment(six(places, directions)), "p.toml");
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->alignment.kind, AlignmentKind::six_points);
    const auto& spec = part->alignment.six_points.value();
    EXPECT_EQ(spec.places[5].at_mm, Eigen::Vector3d(-15, 0, 5));
    EXPECT_EQ(spec.places[1].normal, Eigen::Vector3d(0, 0, 1));
    EXPECT_EQ(spec.options.most_rounds, 10);
    EXPECT_EQ(spec.approach_mm, 3.0);
    const auto keys = parse_part_file(
        with_alignment(six(places, directions,
                           "residual_mm = 0.01\nmoved_mm = 0.1\nmost_rounds = 4\ntouch_standard_mm = 0.002\n"
                           "largest_condition = 50\napproach_mm = 6\nsearch_mm = 7\n")),
        "p.toml");
    ASSERT_TRUE(keys) << keys.error().text();
    const auto& set = keys->alignment.six_points.value();
    EXPECT_EQ(set.options.residual_mm, 0.01);
    EXPECT_EQ(set.options.moved_mm, 0.1);
    EXPECT_EQ(set.options.most_rounds, 4);
    EXPECT_EQ(set.options.touch_standard_mm, 0.002);
    EXPECT_EQ(set.largest_condition, 50.0);
    EXPECT_EQ(set.approach_mm, 6.0);
    EXPECT_EQ(set.search_mm, 7.0);
    EXPECT_FALSE(parse_part_file(session_part_text(), "p.toml")->alignment.six_points);
}

TEST(SixPointSpec, WhatDoesNotHoldIsRefusedInWords) {
    const auto no_x = std::array{"[0, 0, 1]", "[0, 0, 1]", "[0, 0, 1]", "[0, -1, 0]", "[0, -1, 0]", "[0, 1, 0]"};
    const std::string refused = read_error(six(places, no_x));
    EXPECT_TRUE(holds(refused, "do not hold the part")) << refused;
    EXPECT_TRUE(holds(refused, "free is a shift along (1.00, 0.00, 0.00)") ||
                holds(refused, "free is a shift along (-1.00, 0.00, 0.00)"))
        << refused;
    EXPECT_TRUE(holds(refused, "p.toml:")) << refused;
    EXPECT_TRUE(holds(read_error(six(places, directions, "largest_condition = 1.1\n")), "condition number"));
    EXPECT_TRUE(holds(read_error("[alignment]\nkind = \"six_points\"\n"), "six [[alignment.point]]"));
    EXPECT_TRUE(holds(read_error("[alignment]\nkind = \"six_points\"\n[[alignment.point]]\nat_mm = [0, 0, 1]\n"),
                      "there are 1"));
    EXPECT_TRUE(holds(read_error("[alignment]\nmoved_mm = 0.1\n"), "needs [[alignment.point]]"));
    auto table = datum_table("none");
    EXPECT_TRUE(holds(read_error(table), "needs kind = \"six_points\""));
    table = datum_table("blade");
    EXPECT_EQ(read_error(table), "read");
    table.insert(table.find("[[alignment.point]]"), "rotation = \"fixed\"\n");
    EXPECT_TRUE(holds(read_error(table), "moves freely"));
    const auto flat = std::array{"[0, 0, 1]", "[0, 0, 1]", "[0, 0, 0]", "[0, -1, 0]", "[0, -1, 0]", "[-2, 0, 0]"};
    EXPECT_TRUE(holds(read_error(six(places, flat)), "must not be zero"));
}

/// The first of the six is the middle between two sides.
std::string with_middle(const std::string& keys) {
    auto table = six(places, directions);
    const std::string first = "direction = [0, 0, 1]\n";
    return table.insert(table.find(first) + first.size(), keys);
}

TEST(SixPointSpec, AMiddleHasAnOppositeTouch) {
    const auto part = parse_part_file(
        with_alignment(with_middle("opposite_mm = [0, 0, 2]\nopposite_direction = [0, 0.2, -1]\n")), "p.toml");
    ASSERT_TRUE(part) << part.error().text();
    const auto& spec = part->alignment.six_points.value();
    ASSERT_TRUE(spec.places[0].opposite);
    EXPECT_FALSE(spec.places[1].opposite);
    EXPECT_EQ(spec.places[0].opposite->at_mm, Eigen::Vector3d(0, 0, 2));
    EXPECT_NEAR(spec.places[0].opposite->normal->norm(), 1.0, 1e-12);
    EXPECT_TRUE(holds(read_error(with_middle("opposite_direction = [0, 0, -1]\n")), "opposite_mm is missing"));
    EXPECT_TRUE(holds(read_error(with_middle("opposite_mm = [0, 0, 2]\nopposite_direction = [0, 1, 0]\n")),
                      "datum point 1 has no middle: its two touches face away from each other by 90 degrees"));
}

TEST(SixPointSpec, NeedsANominal) {
    const auto part = parse_part_file(
        "[part]\nname = \"u\"\n[nominal]\nkind = \"none\"\n[scan]\nheights_mm = [1]\n"
        "box_mm = [-10, -5, 10, 5]\n" +
            six(places, directions),
        "p.toml");
    ASSERT_FALSE(part);
    EXPECT_TRUE(holds(part.error().message, "needs a nominal")) << part.error().message;
}

TEST(SixPointSpec, TakesTheNormalsOfTheNominal) {
    const SessionPart job(with_alignment(datum_table()));
    const auto points = on_nominal(*job.part.alignment.six_points, *job.nominal);
    ASSERT_TRUE(points) << points.error().text();
    for (std::size_t i = 0; i < 5; ++i) {
        const auto& point = (*points)[i];
        EXPECT_NEAR(point.normal.norm(), 1.0, 1e-12);
        EXPECT_LT((point.place_mm - job.part.alignment.six_points->places[i].at_mm).norm(), 1e-3);
        // Across it the surface beside the point falls away with the square only: along the section and up the span.
        for (const double rise : {-0.02, 0.0, 0.02}) {
            const auto cut = job.nominal->cut(point.place_mm.z() + rise).value();
            for (const auto& beside : cut.points) {
                const Eigen::Vector3d way =
                    Eigen::Vector3d(beside.x(), beside.y(), point.place_mm.z() + rise) - point.place_mm;
                if (way.norm() < 0.03) {
                    EXPECT_NEAR(way.dot(point.normal), 0.0, 1e-3 + way.squaredNorm()) << i;
                }
            }
        }
        // Out of the material: a place before it lies outside the section.
        const auto cut = job.nominal->cut(point.place_mm.z()).value();
        EXPECT_GT(distance_to_outline((point.place_mm + 0.2 * point.normal).head<2>(), cut.points), 0.1);
    }
    EXPECT_EQ((*points)[5].normal, Eigen::Vector3d::UnitZ());

    auto spec = *job.part.alignment.six_points;
    spec.places[2].at_mm.y() += 0.3;
    const auto beside = on_nominal(spec, *job.nominal);
    ASSERT_FALSE(beside);
    EXPECT_EQ(beside.error().code, core::ErrorCode::config_invalid);
    EXPECT_TRUE(holds(beside.error().message, "datum point 3 lies")) << beside.error().message;
    spec.places[2].at_mm.z() = 99.0;
    EXPECT_TRUE(holds(on_nominal(spec, *job.nominal).error().message, "datum point 3 is not on the nominal"));
    // All on one wall of the airfoil: nothing says where the part is along it.
    for (std::size_t i = 0; i < 6; ++i)
        spec.places[i] = job.part.alignment.six_points->places[i % 3];
    const auto free = on_nominal(spec, *job.nominal);
    ASSERT_FALSE(free);
    EXPECT_TRUE(holds(free.error().message, "do not hold the part")) << free.error().message;
}

TEST(SixPointSpec, MiddlesAreTouchedOnBothSides) {
    const SessionPart job(with_alignment(datum_table("six_points", Datums::middles)));
    const auto points = on_nominal(*job.part.alignment.six_points, *job.nominal);
    ASSERT_TRUE(points) << points.error().text();
    ASSERT_TRUE((*points)[1].opposite);
    EXPECT_LT((*points)[1].normal.dot((*points)[1].opposite->normal), -0.5);
    ASSERT_EQ(job.plan.datum_touches.size(), 9U);
    EXPECT_EQ(job.plan.datum_middles, (DatumMiddles{true, true, true, false, false, false}));
    const auto back = parse_plan(plan_to_text(job.plan), "plan.json");
    ASSERT_TRUE(back) << back.error().text();
    EXPECT_EQ(plan_to_text(*back), plan_to_text(job.plan));
    const auto touched = points_touched(back->datum_touches, back->datum_middles, 1.0);
    EXPECT_LT((touched[1].opposite->place_mm - (*points)[1].opposite->place_mm).norm(), 1e-6);
    EXPECT_EQ(datum_touch_name(back->datum_middles, 2), "datum point 2");
    EXPECT_EQ(datum_touch_name(back->datum_middles, 3), "the opposite touch of datum point 2");
    EXPECT_EQ(datum_touch_name(back->datum_middles, 8), "datum point 6");
    const auto findings = check_plan(job.plan, job.part, job.nominal.get(), nullptr);
    EXPECT_TRUE(require_sound(findings));
    EXPECT_TRUE(std::any_of(findings.begin(), findings.end(), [](const Finding& finding) {
        return holds(finding.text, "six datum points (3 of them middles of two touches)");
    }));
}

TEST(SixPointSpec, IsPartOfThePlan) {
    const SessionPart job(with_alignment(datum_table()));
    ASSERT_EQ(job.plan.datum_touches.size(), 6U);
    EXPECT_NE(job.plan.hash, SessionPart().plan.hash);
    const auto back = parse_plan(plan_to_text(job.plan), "plan.json");
    ASSERT_TRUE(back) << back.error().text();
    EXPECT_EQ(plan_to_text(*back), plan_to_text(job.plan));
    EXPECT_FALSE(holds(plan_to_text(job.plan), "datum_middles"));
    const auto points = points_touched(back->datum_touches, back->datum_middles, 1.0);
    EXPECT_LT((points[5].place_mm - Eigen::Vector3d(0, 0, 60)).norm(), 1e-9);
    drivers::Capabilities machine;
    machine.limit_min_mm = {-200, -200, -50};
    machine.limit_max_mm = {200, 200, 300};
    const auto findings = check_plan(job.plan, job.part, job.nominal.get(), &machine);
    EXPECT_TRUE(require_sound(findings));
    EXPECT_TRUE(std::any_of(findings.begin(), findings.end(), [](const Finding& finding) {
        return finding.severity == Severity::note && holds(finding.text, "six datum points");
    }));
    machine.limit_max_mm.z() = 63.5;  // the ball begins at 64 above the tip
    const auto low = require_sound(check_plan(job.plan, job.part, job.nominal.get(), &machine));
    ASSERT_FALSE(low);
    EXPECT_TRUE(holds(low.error().message, "datum point 6: z = 64.000 mm lies outside")) << low.error().message;
    auto inside = job.plan;
    inside.datum_touches[0].normal = -inside.datum_touches[0].normal;
    EXPECT_FALSE(require_sound(check_plan(inside, job.part, job.nominal.get(), nullptr)));
}

}  // namespace
}  // namespace cmm::acquisition
