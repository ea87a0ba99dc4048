// SPDX-License-Identifier: Apache-2.0
#include "acquisition/section_finisher.hpp"

#include <nlohmann/json.hpp>
#include <numeric>
#include <thread>

#include "tests/acquisition/leaning_part.hpp"
#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {
namespace {

using core::Duration;

TEST(LatencySummary, TakesTheNearestRank) {
    EXPECT_EQ(summarise({}).count, 0U);
    EXPECT_EQ(summarise({}).max_ms, 0.0);
    const auto one = summarise({3.5});
    EXPECT_EQ(one.count, 1U);
    EXPECT_EQ(one.p50_ms, 3.5);
    EXPECT_EQ(one.p99_ms, 3.5);
    EXPECT_EQ(one.max_ms, 3.5);
    EXPECT_EQ(summarise({4.0, 1.0, 3.0, 2.0}).p50_ms, 2.0);
    std::vector<double> times(200);
    std::iota(times.rbegin(), times.rend(), 1.0);  // 200 ... 1
    const auto many = summarise(times);
    EXPECT_EQ(many.count, 200U);
    EXPECT_EQ(many.p50_ms, 100.0);
    EXPECT_EQ(many.p99_ms, 198.0);
    EXPECT_EQ(many.max_ms, 200.0);
}

struct SectionFinisherTest : ::testing::Test {
    SessionPart job;
    std::vector<SectionSetup> setups{job.setup(0), job.setup(1)};
    core::ManualClock clock;
    EventHub events{clock};
    EventLog log{events};
    Workers workers{1};

    std::unique_ptr<LiveSection> section(std::size_t index, double thicken_mm = 0.0) const {
        const auto samples = samples_of(job.plan.paths[index], 1, 1, thicken_mm);
        auto live = std::make_unique<LiveSection>(setups[index], test_lsb_mm, core::PartFromMachine(), samples.size());
        live->add(samples);
        return live;
    }
};

TEST_F(SectionFinisherTest, HandsSectionsOverByIndexAndOnce) {
    SectionFinisher finisher(events, clock, workers);
    finisher.submit(section(1));
    finisher.submit(section(0));
    const auto results = finisher.take_all();
    ASSERT_EQ(results.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(results[i].index, i);
        EXPECT_TRUE(results[i].has_contour()) << results[i].why;
        EXPECT_EQ(results[i].decision(), Decision::accept);
        EXPECT_EQ(results[i].points.size(), job.plan.paths[i].points.size());
    }
    EXPECT_TRUE(finisher.take_all().empty());
}

TEST_F(SectionFinisherTest, AnnouncesWhatItFound) {
    auto samples = samples_of(job.plan.paths[0], 1, 1, 0.3);
    samples[10].flags = core::sample_flag::no_contact;
    auto live = std::make_unique<LiveSection>(setups[0], test_lsb_mm, core::PartFromMachine(), samples.size());
    live->add(samples);
    std::vector<SectionResult> results;
    {
        SectionFinisher finisher(events, clock, workers);
        finisher.submit(std::move(live));
        results = finisher.take_all();
    }
    ASSERT_EQ(results.size(), 1U);
    EXPECT_EQ(results[0].decision(), Decision::reject);

    ASSERT_FALSE(log.all().empty());
    EXPECT_EQ(log.all().front().kind, EventKind::section_final);
    EXPECT_DOUBLE_EQ(log.all().front().t_machine_s, 2e-3 * static_cast<double>(samples.size()));
    const auto rejected = log.of(EventKind::point_rejected);
    ASSERT_EQ(rejected.size(), results[0].rejected());
    EXPECT_TRUE(holds(rejected[0].payload, "\"sample\":11,")) << rejected[0].payload;
    EXPECT_TRUE(holds(rejected[0].payload, "no_contact")) << rejected[0].payload;
    const auto revised = log.of(EventKind::section_revised);
    ASSERT_EQ(revised.size(), 1U) << "by the nominal's lean";
    EXPECT_TRUE(holds(revised[0].payload, "\"compensation\":\"provisional\"")) << revised[0].payload;
    EXPECT_EQ(log.of(EventKind::characteristic_updated).size(), 2 * results[0].characteristics.size());
    EXPECT_EQ(log.all().back().kind, EventKind::gate_decision);
    EXPECT_TRUE(holds(log.all().back().payload, "\"decision\":\"reject\",\"certain\":true"))
        << log.all().back().payload;
}

TEST_F(SectionFinisherTest, LatencyCountsFromTheLastSample) {
    SectionFinisher finisher(events, clock, workers);
    auto live = section(0);
    clock.advance(*live->last_sample_host_time() + std::chrono::microseconds(12345));
    finisher.submit(std::move(live));
    EXPECT_EQ(finisher.take_all().size(), 1U);
    const auto latency = finisher.latency();
    for (const auto& summary : {latency.closed, latency.decided}) {
        EXPECT_EQ(summary.count, 1U);
        EXPECT_NEAR(summary.p50_ms, 12.345, 1e-9);
        EXPECT_NEAR(summary.max_ms, 12.345, 1e-9);
    }
    EXPECT_TRUE(holds(log.of(EventKind::section_final).at(0).payload, "\"latency_ms\":12.345"));
    EXPECT_TRUE(holds(log.of(EventKind::gate_decision).at(0).payload, "\"latency_ms\":12.345"));
}

/// Of the worker, and no longer than it took on the wall; the decision comes later and has taken more.
TEST_F(SectionFinisherTest, SaysHowLongAProcessorWorkedForIt) {
    const core::SystemClock wall;
    const auto begun = wall.now();
    SectionFinisher finisher(events, clock, workers);
    finisher.submit(section(0));
    (void)finisher.take_all();
    const double most_ms = 1e3 * core::seconds(wall.now() - begun);
    const auto processor_ms = [&](EventKind kind) {
        return nlohmann::json::parse("{" + log.of(kind).at(0).payload + "}").at("processor_ms").get<double>();
    };
    const double closed_ms = processor_ms(EventKind::section_final),
                 decided_ms = processor_ms(EventKind::gate_decision);
    EXPECT_GT(closed_ms, 0.1) << "a fit";
    EXPECT_GT(decided_ms, closed_ms);
    EXPECT_LE(decided_ms, most_ms);
}

TEST_F(SectionFinisherTest, ARestoredSectionHasNoLatency) {
    SectionFinisher finisher(events, clock, workers);
    clock.advance(std::chrono::hours(24));
    auto restored = std::make_unique<LiveSection>(setups[0], test_lsb_mm, core::PartFromMachine(), 0);
    restored->restore(section(0)->points());
    finisher.submit(std::move(restored));
    ASSERT_EQ(finisher.take_all().size(), 1U);
    EXPECT_EQ(finisher.latency().closed.count + finisher.latency().decided.count, 0U);
    EXPECT_TRUE(holds(log.of(EventKind::section_final).at(0).payload, "\"latency_ms\":null,\"processor_ms\":null"));
}

TEST_F(SectionFinisherTest, ASectionThatCannotBeFittedSaysWhy) {
    SectionFinisher finisher(events, clock, workers);
    auto live = std::make_unique<LiveSection>(setups[0], test_lsb_mm, core::PartFromMachine(), 0);
    const auto samples = samples_of(job.plan.paths[0], 1, 1);
    live->add(std::span(samples).first(5));
    finisher.submit(std::move(live));
    const auto results = finisher.take_all();
    ASSERT_EQ(results.size(), 1U);
    EXPECT_FALSE(results[0].has_contour());
    EXPECT_FALSE(results[0].why.empty());
    EXPECT_TRUE(holds(log.of(EventKind::section_final).at(0).payload, "\"why\":"));
}

TEST_F(SectionFinisherTest, ARehearsalLeavesNoTrace) {
    SectionFinisher finisher(events, clock, workers);
    finisher.rehearse(setups[1], section(1, 0.3)->points(), 100.0);
    finisher.submit(section(0));
    const auto results = finisher.take_all();
    ASSERT_EQ(results.size(), 1U);
    EXPECT_EQ(results[0].index, 0U);
    EXPECT_EQ(results[0].decision(), Decision::accept);
    EXPECT_EQ(log.of(EventKind::section_final).size(), 1U);
    EXPECT_EQ(finisher.latency().closed.count, 1U);
    EXPECT_EQ(finisher.latency().decided.count, 1U);
}

TEST_F(SectionFinisherTest, OnlyWhatIsCertainEndsARunAndWhatBecomesCertainDoes) {
    const LeaningPart part(leaning_text("profile_mm = 0.1\n"), leans_more);
    const auto unknown = too_thick_without_nominal(part);
    const auto live = [&](std::size_t index) {
        auto section =
            std::make_unique<LiveSection>(unknown[index], test_lsb_mm, core::PartFromMachine(), std::size_t{0});
        section->restore(part.points(index));
        return section;
    };
    SectionFinisher finisher(events, clock, workers);
    const auto last_decision = [&] {
        while (!finisher.idle())
            std::this_thread::yield();
        std::string last;
        for (const auto& event : log.of(EventKind::gate_decision))
            if (holds(event.payload, "\"section\":0,")) last = event.payload;
        return last;
    };
    finisher.submit(live(0));
    EXPECT_EQ(last_decision(),
              "\"section\":0,\"decision\":\"reject\",\"certain\":false,\"latency_ms\":null,\"processor_ms\":null");
    EXPECT_FALSE(finisher.rejected()) << "its lean may make it thick";
    finisher.submit(live(1));
    EXPECT_EQ(last_decision(),
              "\"section\":0,\"decision\":\"reject\",\"certain\":true,\"latency_ms\":null,\"processor_ms\":null")
        << "of the revised section";
    EXPECT_TRUE(finisher.rejected());
}

TEST_F(SectionFinisherTest, TheEndWaitsForWhatWasSubmitted) {
    {
        SectionFinisher finisher(events, clock, workers);
        finisher.submit(section(0));
        finisher.submit(section(1));
    }
    EXPECT_EQ(log.of(EventKind::section_final).size(), 2U);
    EXPECT_EQ(log.of(EventKind::section_revised).size(), 3U) << "the lower one again, when the upper had closed";
    EXPECT_EQ(log.of(EventKind::gate_decision).size(), 5U);
}

}  // namespace
}  // namespace cmm::acquisition
