// SPDX-License-Identifier: Apache-2.0
#include "acquisition/gauge_study.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "acquisition/run_results.hpp"
#include "core/rng.hpp"
#include "tests/acquisition/gauge_example.hpp"
#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {
namespace {

StudyRun run_of(const std::string& part, const std::string& appraiser, int number, std::optional<double> value) {
    StudyRun run{part,
                 appraiser,
                 "run-" + std::to_string(number),
                 "2025-01-02T03:04:" + std::to_string(100 + number),
                 "rotor",
                 "plan-1",
                 {}};
    Characteristic one;
    one.name = "chord z 20.000";
    one.method = "NOSETAIL";
    one.value = value;
    one.lower = -3.0;
    one.upper = 3.0;
    if (value) one.u95 = 0.4;
    run.characteristics.push_back(one);
    return run;
}

/// The published example as 90 runs; trial by trial, as a person would measure.
std::vector<StudyRun> example_runs() {
    const auto values = aiag_values();
    std::vector<StudyRun> runs;
    for (std::size_t trial = 0; trial < 3; ++trial)
        for (std::size_t appraiser = 0; appraiser < 3; ++appraiser)
            for (std::size_t part = 0; part < 10; ++part)
                runs.push_back(run_of("P" + std::to_string(part + 1),
                                      std::string(1, static_cast<char>('A' + appraiser)), static_cast<int>(runs.size()),
                                      values.at(part, appraiser, trial)));
    return runs;
}

TEST(GaugeStudy, ThePublishedExampleAsRuns) {
    auto runs = example_runs();
    std::reverse(runs.begin(), runs.end());  // time says the order, not the command line
    const auto study = make_gauge_study(runs);
    ASSERT_TRUE(study) << study.error().message;
    EXPECT_EQ(study->parts.size(), 10U);
    EXPECT_EQ(study->parts.front(), "P1");
    EXPECT_EQ(study->appraisers, (std::vector<std::string>{"A", "B", "C"}));
    ASSERT_EQ(study->characteristics.size(), 1U);
    const auto& one = study->characteristics[0];
    EXPECT_EQ(one.trials, 3U);
    EXPECT_EQ(one.missing, 0U);
    EXPECT_NEAR(one.components->gauge.deviation, 0.302373, 2e-6);
    EXPECT_DOUBLE_EQ(one.tolerance.value(), 6.0);
    EXPECT_DOUBLE_EQ(one.declared.value(), 0.2);
    EXPECT_NEAR(one.observed_to_declared().value(), 0.199933 / 0.2, 1e-5);
    const auto text = study_text(*study);
    EXPECT_TRUE(holds(text, "10 parts, 3 appraisers (A, B, C), 3 trials, 90 runs")) << text;
    EXPECT_TRUE(holds(text, " 27.9 ")) << text;
    EXPECT_TRUE(holds(text, " 30.2 ")) << "of the tolerance\n" << text;
    const auto json = nlohmann::json::parse(study_json(*study));
    const auto& components = json["characteristics"][0]["components"];
    EXPECT_NEAR(components["gauge"]["standard"], 0.302373, 2e-6);
    EXPECT_EQ(components["distinct_categories"], 4.0);
    EXPECT_TRUE(components["interaction"].is_null()) << "pooled";
    EXPECT_EQ(json["characteristics"][0]["values"].size(), 90U);
    const auto csv = study_csv(*study);
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 2);
    const auto line = csv.find('\n') + 1;
    EXPECT_EQ(std::count(csv.begin(), csv.begin() + static_cast<std::ptrdiff_t>(line), ','),
              std::count(csv.begin() + static_cast<std::ptrdiff_t>(line), csv.end(), ','));
    const auto html = study_html(*study);
    EXPECT_TRUE(holds(html, "<svg"));
    EXPECT_TRUE(holds(html, "27.9"));
}

TEST(GaugeStudy, WhatIsNotEvaluableIsCountedAndTheDesignStaysBalanced) {
    auto runs = example_runs();
    runs[7].characteristics[0].value.reset();  // P8 by A, first trial
    const auto two = make_gauge_study(runs).value().characteristics[0];
    EXPECT_EQ(two.missing, 1U);
    EXPECT_EQ(two.trials, 2U);
    EXPECT_EQ(two.left_out, 29U);
    EXPECT_EQ(two.components->repeats.freedom, 30.0);
    EXPECT_EQ(two.values.size(), 60U);
    runs[37].characteristics[0].value.reset();  // P8 by A once more
    const auto study = make_gauge_study(runs).value();
    EXPECT_FALSE(study.characteristics[0].components);
    EXPECT_EQ(study.characteristics[0].why, "1 value of part P8 by A");
    EXPECT_TRUE(holds(study_text(study), "not evaluated, 1 value of part P8 by A"));
    EXPECT_TRUE(nlohmann::json::parse(study_json(study))["characteristics"][0]["components"].is_null());
    const auto csv = study_csv(study);
    const auto line = static_cast<std::ptrdiff_t>(csv.find('\n') + 1);
    EXPECT_EQ(std::count(csv.begin(), csv.begin() + line, ','), std::count(csv.begin() + line, csv.end(), ','));
}

TEST(GaugeStudy, RefusesWhatIsNoStudy) {
    const auto complaint = [](const std::vector<StudyRun>& runs) {
        const auto study = make_gauge_study(runs);
        return study ? std::string() : study.error().message;
    };
    EXPECT_TRUE(holds(complaint({}), "needs runs"));
    auto runs = example_runs();
    runs.push_back(runs[4]);
    EXPECT_TRUE(holds(complaint(runs), "run-4 is named twice")) << complaint(runs);
    runs = example_runs();
    runs[3].plan = "plan-2";
    EXPECT_TRUE(holds(complaint(runs), "another part program"));
    runs = example_runs();
    runs[3].part.clear();
    EXPECT_TRUE(holds(complaint(runs), "run-3 does not say which part"));
    runs = example_runs();
    std::erase_if(runs, [](const StudyRun& run) { return run.part == "P4" && run.appraiser == "B"; });
    EXPECT_TRUE(holds(complaint(runs), "part P4 was measured 0 times by B")) << complaint(runs);
    runs = example_runs();
    runs.resize(30);
    EXPECT_TRUE(holds(complaint(runs), "was measured 1 time by A")) << complaint(runs);
    runs = example_runs();
    runs[50].characteristics[0].method = "CALIPER";
    const auto study = make_gauge_study(runs).value();
    EXPECT_FALSE(study.characteristics[0].components) << "values by two methods are not compared";
    EXPECT_TRUE(holds(study.characteristics[0].why, "run-50"));
}

TEST(GaugeStudy, SaysThatOneAppraiserTellsRepeatabilityOnly) {
    auto runs = example_runs();
    std::erase_if(runs, [](const StudyRun& run) { return run.appraiser != "B"; });
    const auto study = make_gauge_study(runs).value();
    EXPECT_TRUE(holds(study_text(study), "One appraiser: GRR is the repeatability alone"));
    EXPECT_FALSE(study.characteristics[0].components->reproducibility);
}

/// What repeated runs scatter is what each of them says of itself.
TEST(GaugeStudy, RepeatabilityIsTheUncertaintyOfASingleRun) {
    constexpr double noise_mm = 0.002;
    constexpr int repeats = 25;
    // Upright walls: what a run says of itself holds no error of the 2-D offset, which repeating does not show.
    const SessionPart job(upright_part_text() + "[fitting]\ncompensation = \"2d\"\n");
    core::Rng rng(12);
    std::vector<StudyRun> runs;
    for (int k = 0; k < repeats; ++k) {
        std::vector<PointSection> sections(2);
        for (std::size_t i = 0; i < 2; ++i)
            for (const auto& planned : job.plan.paths[i].points)
                sections[i].points_mm.emplace_back(planned.centre_mm + noise_mm * rng.normal() * planned.normal);
        // Of what the machine does alike in every run nothing shows in their differences.
        auto part = job.part;
        part.uncertainty.stated.length_mm = 5e-3;
        auto result = results_of_points(sections, 1.0, &part);
        ASSERT_TRUE(result) << result.error().message;
        result->run_id = std::to_string(k);
        runs.push_back(study_run(*result, "plan", "1", "machine"));
    }
    const auto study = make_gauge_study(std::move(runs)).value();
    // 24 degrees of freedom: chi-square 12.40 and 39.36 in 95 of 100 cases; one of six more rarely beyond 99.9 %.
    const double low = std::sqrt(8.085 / 24.0), high = std::sqrt(51.18 / 24.0);
    int compared = 0;
    for (const auto& one : study.characteristics) {
        if (!one.name.starts_with("max_thickness") && !one.name.starts_with("chord")) continue;
        ++compared;
        EXPECT_EQ(one.missing, 0U) << one.name;
        EXPECT_GT(one.observed_to_declared().value(), low) << one.name;
        EXPECT_LT(one.observed_to_declared().value(), high) << one.name;
    }
    EXPECT_EQ(compared, 4);
}

}  // namespace
}  // namespace cmm::acquisition
