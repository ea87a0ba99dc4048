// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sample_intake.hpp"

#include "tests/acquisition/session_fixture.hpp"
#include "tests/acquisition/temp_folder.hpp"

namespace cmm::acquisition {
namespace {

struct SampleIntakeTest : ::testing::Test {
    SessionPart job;
    SectionSetup setup = job.setup(0);
    TempFolder folder;
    std::unique_ptr<Journal> journal =
        std::move(Journal::create(folder.path("run.cmmrun"), session_header(job)).value());
    core::ManualClock clock;
    EventHub events{clock};
    EventLog log{events};
    SampleIntake intake{*journal, events};
    std::vector<core::Sample> samples = samples_of(job.plan.paths[0], 3, 1);
    int completions = 0;
    std::unique_ptr<LiveSection> completed;

    void begin(std::size_t expected, SampleIntake::Follower follower = {}, SampleIntake::Nearing nearing = {}) {
        intake.begin(
            3, std::make_unique<LiveSection>(setup, test_lsb_mm, core::PartFromMachine(), expected),
            [this](std::unique_ptr<LiveSection> section) {
                ++completions;
                completed = std::move(section);
            },
            std::move(follower), std::move(nearing));
    }
    void feed(std::size_t batch) {
        for (std::size_t i = 0; i < samples.size(); i += batch) {
            const auto status = intake.on_samples(std::span(samples).subspan(i, std::min(batch, samples.size() - i)));
            ASSERT_TRUE(status) << status.error().text();
        }
    }
};

TEST_F(SampleIntakeTest, CompletesOnceWithAllPointsWhateverTheBatch) {
    begin(samples.size());
    feed(7);
    EXPECT_EQ(completions, 1);
    ASSERT_TRUE(completed);
    EXPECT_EQ(completed->points().size(), samples.size());
    EXPECT_EQ(completed->points().back().sequence, samples.back().sequence);
    EXPECT_EQ(intake.end(), nullptr);
    EXPECT_EQ(intake.received(), samples.size());
    std::size_t announced = 0;
    for (const auto& event : log.of(EventKind::sample_batch)) {
        EXPECT_TRUE(holds(event.payload, "\"first_seq\":" + std::to_string(announced + 1) + ",")) << event.payload;
        announced += std::stoul(event.payload.substr(event.payload.find("\"count\":") + 8));
    }
    EXPECT_EQ(announced, samples.size());
}

TEST_F(SampleIntakeTest, OnlySamplesOfItsPathThatAreNoTouchesEnterTheSection) {
    samples[0].path = 2;
    samples[1].flags = core::sample_flag::touch;
    samples[5].flags = core::sample_flag::touch;
    samples[9].path = 4;
    begin(samples.size() - 4);
    feed(samples.size());
    ASSERT_EQ(completions, 1);
    EXPECT_EQ(completed->points().size(), samples.size() - 4);
    for (const auto& point : completed->points()) {
        EXPECT_TRUE(point.sequence != 1 && point.sequence != 2 && point.sequence != 6 && point.sequence != 10);
    }
    EXPECT_EQ(journal->samples()->size(), samples.size());  // nothing is lost
}

TEST_F(SampleIntakeTest, WithoutASectionSamplesGoIntoTheJournal) {
    feed(50);
    EXPECT_TRUE(log.all().empty());
    ASSERT_TRUE(journal->flush());
    EXPECT_EQ(intake.durable_sequence(), samples.size());
}

TEST_F(SampleIntakeTest, ShowsTheSectionWhileItsPointsArrive) {
    begin(samples.size());
    feed(1);  // a millisecond apart: the number of points decides
    const auto shown = log.of(EventKind::section_updated);
    EXPECT_EQ(shown.size(), 1 + (samples.size() - 1) / 64 + ((samples.size() - 1) % 64 > 0 ? 1 : 0));
    ASSERT_GE(shown.size(), 2U);
    EXPECT_TRUE(holds(shown.front().payload, "\"state\":\"open\",\"points\":1,")) << shown.front().payload;
    EXPECT_TRUE(holds(shown.back().payload, "\"state\":\"closed\"")) << shown.back().payload;
}

TEST_F(SampleIntakeTest, ShowsASlowSectionByTime) {
    for (std::size_t i = 0; i < samples.size(); ++i)
        samples[i].host_time_ns = static_cast<std::int64_t>(1'000'000'000 + 50'000'000 * i);
    begin(samples.size());
    feed(1);
    // Every 100 ms: every second point; the last one in any case.
    EXPECT_EQ(log.of(EventKind::section_updated).size(), samples.size() / 2 + 1);
}

TEST_F(SampleIntakeTest, SaysOnceThatASectionNearsItsEnd) {
    for (std::size_t i = 0; i < samples.size(); ++i)
        samples[i].host_time_ns = static_cast<std::int64_t>(1'000'000'000 + 10'000'000 * i);
    std::vector<std::pair<std::size_t, double>> seen;  // points that are missing, time left
    begin(samples.size(), {},
          [&](const LiveSection& section, double left_ms) { seen.emplace_back(section.missing(), left_ms); });
    feed(1);
    ASSERT_EQ(seen.size(), 1U);
    EXPECT_EQ(seen[0].first, 5U);
    EXPECT_NEAR(seen[0].second, 50.0, 1e-6);
}

TEST_F(SampleIntakeTest, OfASectionWithoutAKnownEndNothingIsSaid) {
    int seen = 0;
    begin(0, {}, [&](const LiveSection&, double) { ++seen; });
    feed(1);
    EXPECT_EQ(seen, 0);
}

TEST_F(SampleIntakeTest, TheFollowerSeesEverySampleOfTheSectionInOrder) {
    samples[4].flags = core::sample_flag::touch;
    std::vector<std::uint64_t> seen;
    begin(0, [&](const core::Sample& sample) -> core::Status {
        seen.push_back(sample.sequence);
        return {};
    });
    feed(6);
    ASSERT_EQ(seen.size(), samples.size() - 1);
    EXPECT_EQ(seen[3], 4U);
    EXPECT_EQ(seen[4], 6U);
    const auto left = intake.end();
    ASSERT_TRUE(left);  // it never knew its number of points
    EXPECT_EQ(left->points().size(), samples.size() - 1);
    EXPECT_EQ(completions, 0);
}

TEST_F(SampleIntakeTest, AFollowerThatFailsEndsTheScanButLosesNoSample) {
    begin(samples.size(), [](const core::Sample& sample) -> core::Status {
        if (sample.sequence == 15) return core::fail(core::ErrorCode::fit_not_evaluable, "the surface was lost");
        return {};
    });
    ASSERT_TRUE(intake.on_samples(std::span(samples).first(10)));
    const auto status = intake.on_samples(std::span(samples).subspan(10, 10));
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, core::ErrorCode::fit_not_evaluable);
    EXPECT_EQ(journal->samples()->size(), 20U);
    EXPECT_EQ(completions, 0);
    EXPECT_TRUE(intake.end());
}

TEST_F(SampleIntakeTest, AGapIsRefusedByTheJournal) {
    begin(samples.size());
    ASSERT_TRUE(intake.on_samples(std::span(samples).first(10)));
    const auto status = intake.on_samples(std::span(samples).subspan(11, 1));
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, core::ErrorCode::journal_corrupt);
    EXPECT_EQ(intake.received(), 10U);
    EXPECT_EQ(intake.section()->points().size(), 10U);
}

}  // namespace
}  // namespace cmm::acquisition
