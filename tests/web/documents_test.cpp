// SPDX-License-Identifier: Apache-2.0
#include "web/server/documents.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "acquisition/exports.hpp"
#include "acquisition/operator_choice.hpp"
#include "tests/acquisition/nom_blade.hpp"
#include "tests/web/recorded_run.hpp"
#include "web/server/choice_request.hpp"

namespace cmm::web {
namespace {

using nlohmann::json;

struct Documents : ::testing::Test {
    test::RecordedRun run;
    std::unique_ptr<acquisition::RunReview> review =
        std::move(acquisition::RunReview::open(run.folder + "/run.cmmrun").value());
};

TEST_F(Documents, PlanHasEverySectionWithItsNominal) {
    const auto plan = json::parse(plan_document("first", *review).value());
    EXPECT_EQ(plan.at("run_id"), "run-1");
    EXPECT_EQ(plan.at("profile_mm"), 0.1);
    ASSERT_EQ(plan.at("sections").size(), 2U);
    EXPECT_EQ(plan["sections"][1]["z_mm"], 40.0);
    EXPECT_GT(plan["sections"][1]["nominal"].size(), 100U);
}

TEST_F(Documents, PointsLieWhereTheBallWasAndOnTheNominal) {
    const auto all = json::parse(points_document(*review, 0).value());
    ASSERT_EQ(all.at("points").size(), run.points + 40);
    EXPECT_EQ(all.at("last"), run.points + 40);
    for (std::size_t i = 0; i < run.points; ++i) {
        const auto& point = all["points"][i];
        EXPECT_EQ(point[0], i + 1);
        EXPECT_EQ(point[1], 0);
        EXPECT_NEAR(point[2].get<double>(), run.job.plan.paths[0].points[i].centre_mm.x(), 1e-4);
        EXPECT_NEAR(point[5].get<double>(), 0.0, 2e-4) << "the samples lie a ball's radius from the nominal";
        const double nx = point[6].get<double>(), ny = point[7].get<double>();
        EXPECT_NEAR(nx * nx + ny * ny, 1.0, 1e-3);
    }
    const auto later = json::parse(points_document(*review, run.points + 30).value());
    EXPECT_EQ(later.at("points").size(), 10U);
    EXPECT_EQ(json::parse(points_document(*review, 1'000'000).value()).at("points").size(), 0U);
}

TEST_F(Documents, ASectionIsWhatTheFilesSay) {
    const auto section = json::parse(section_document(*review, 0).value());
    EXPECT_TRUE(section.at("finished"));
    EXPECT_TRUE(section.at("closed"));
    const auto& result = **review->result_at(0);
    ASSERT_EQ(section.at("contour").size(), result.fit->contour.size());
    EXPECT_NEAR(section["contour"][7][0].get<double>(), result.fit->contour[7].position_mm.x(), 1e-4);
    EXPECT_NEAR(section["contour"][7][5].get<double>(), *result.deviation_mm[7], 1e-5);
    EXPECT_EQ(section.at("points").size(), run.points);
    EXPECT_EQ(section.at("decision"), "accept");
    EXPECT_FALSE(json::parse(section_document(*review, 1).value()).at("finished"));
    EXPECT_EQ(section_document(*review, 2).error().code, core::ErrorCode::input_missing);
}

/// Where the nominal has tolerances at its points, the rows of the contour have them.
TEST_F(Documents, ASectionHasTheTolerancesOfItsPoints) {
    EXPECT_EQ(json::parse(section_document(*review, 0).value())["contour"][7].size(), 7U) << "here it has none";
    const acquisition::TempFolder folder;
    const auto nominal = folder.write(
        "b.nom",
        acquisition::nom::written({}, {.tolerance = [](const acquisition::synthetic::ContourPoint& point, double) {
                                      return std::pair(-0.05, point.zone == fitting::Zone::suction ? 0.08 : 0.03);
                                  }}));
    const test::RecordedRun other("[part]\nname = \"n\"\n[nominal]\nkind = \"nom\"\nfiles = [\"" + nominal +
                                  "\"]\n[scan]\nheights_mm = [10, 25]\npitch_mm = 0.5\n");
    const auto by_point = acquisition::RunReview::open(other.folder + "/run.cmmrun");
    ASSERT_TRUE(by_point) << by_point.error().text();
    const auto section = json::parse(section_document(**by_point, 0).value());
    std::size_t wide = 0, narrow = 0;
    for (const auto& row : section.at("contour")) {
        ASSERT_EQ(row.size(), 9U);
        EXPECT_EQ(row[7], -0.05);
        wide += row[8] == 0.08;
        narrow += row[8] == 0.03;
    }
    EXPECT_GT(wide, 500U) << "the suction side";
    EXPECT_GT(narrow, 500U);
}

TEST_F(Documents, AChoiceIsReadBackFromTheResult) {
    acquisition::OperatorChoice choice;
    ASSERT_TRUE(apply_choice(R"({"reject":[7,9]})", choice));
    ASSERT_TRUE(apply_choice(R"({"undo":[9]})", choice));
    review->choose(choice);
    const auto result = json::parse(result_document("first", *review).value());
    EXPECT_EQ(result.at("choice").at("rejected"), json::parse("[7]"));
    ASSERT_TRUE(acquisition::write_outputs(review->result().value(), run.folder));
    EXPECT_EQ(recorded_choice(run.folder, "run-1").rejected(), (std::set<std::uint64_t>{7}));
    EXPECT_TRUE(recorded_choice(run.folder, "run-2").empty()) << "an earlier run in the same folder";
    const auto summary = json::parse(summary_document("first", run.folder));
    EXPECT_EQ(summary.at("part"), "blade");
    EXPECT_GT(summary.at("worst").at("chord").at("value_mm"), 1.0);
}

TEST(Choice, OtherFormsAreRefusedAndChangeNothing) {
    acquisition::OperatorChoice choice;
    choice.reject(3);
    for (const char* bad : {"", "[]", "{}", "7", "{\"reject\":7}", "{\"reject\":[-1]}", "{\"reject\":[1.5]}",
                            "{\"reject\":[\"1\"]}", "{\"reject\":[4],\"delete\":[1]}", "{\"reject\":[4]", "\xff\xfe"})
        EXPECT_FALSE(apply_choice(bad, choice)) << bad;
    std::string many = "{\"reject\":[0";
    for (int i = 0; i < 10'000; ++i)
        many += ",1";
    EXPECT_FALSE(apply_choice(many + "]}", choice));
    EXPECT_EQ(choice.rejected(), (std::set<std::uint64_t>{3}));
    EXPECT_TRUE(choice.restored().empty());
}

TEST_F(Documents, ResultsOfOthersAreNotTakenForThisRuns) {
    for (const char* foreign :
         {R"({"part":7})", R"({"run":{"id":"run-2"},"verdict":"accept"})", "nonsense", R"({"run":[]})"}) {
        std::ofstream(run.folder + "/result.json") << foreign;
        const auto summary = json::parse(summary_document("first", run.folder));
        EXPECT_FALSE(summary.contains("verdict")) << foreign;
        EXPECT_EQ(summary.at("complete"), false);
    }
    for (const char* broken :
         {R"({"run":{"id":"run-1"},"sections":[1,2]})", R"({"run":{"id":"run-1"},"part":7})",
          R"({"run":{"id":"run-1"},"sections":[{"characteristics":[{"name":"a","value_mm":"x"}]}]})"}) {
        std::ofstream(run.folder + "/result.json") << broken;
        EXPECT_NO_THROW(static_cast<void>(summary_document("first", run.folder))) << broken;
        EXPECT_NO_THROW(static_cast<void>(recorded_choice(run.folder, "run-1"))) << broken;
    }
    EXPECT_TRUE(json::parse(summary_document("x", run.runs.path("none"))).contains("problem"));
}

}  // namespace
}  // namespace cmm::web
