// SPDX-License-Identifier: Apache-2.0
#include "acquisition/live_section.hpp"

#include <Eigen/Geometry>

#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {
namespace {

using State = LiveSnapshot::State;

struct LiveSectionTest : ::testing::Test {
    SessionPart job;
    SectionSetup setup = job.setup(0);
    const PlannedPath& path = job.plan.paths[0];

    LiveSection section(std::size_t expected) const { return {setup, test_lsb_mm, core::PartFromMachine(), expected}; }
    double worst(const std::vector<core::Sample>& samples) const {
        auto live = section(samples.size());
        live.add(samples);
        return live.snapshot().worst_deviation_mm.value();
    }
    /// The planned samples, `count` of them from `first` on lifted off by half a millimetre.
    std::vector<core::Sample> with_bad_run(std::size_t first, std::size_t count) const {
        auto samples = samples_of(path, 1, 1, 0.02);
        for (std::size_t i = first; i < first + count; ++i)
            samples[i] = sample_at(samples[i].sequence, 1, path.points[i].centre_mm + 0.5 * path.points[i].normal);
        return samples;
    }
};

TEST_F(LiveSectionTest, FollowsItsPointsUntilAllAreThere) {
    const auto samples = samples_of(path, 1, 1);
    auto live = section(samples.size());
    EXPECT_EQ(live.snapshot().state, State::empty);
    double length_mm = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        EXPECT_FALSE(live.complete());
        live.add(std::span(samples).subspan(i, 1));
        if (i > 0) length_mm += (path.points[i].centre_mm - path.points[i - 1].centre_mm).norm();
        const auto now = live.snapshot();
        EXPECT_EQ(now.points, i + 1);
        EXPECT_EQ(now.state, i + 1 < samples.size() ? State::open : State::closed);
        EXPECT_NEAR((now.last_mm - path.points[i].centre_mm).norm(), 0.0, test_lsb_mm);
        EXPECT_EQ(now.worst_deviation_mm.has_value(), i >= 6);
    }
    EXPECT_TRUE(live.complete());
    EXPECT_NEAR(live.snapshot().length_mm, length_mm, 0.05);
    EXPECT_LT(std::abs(*live.snapshot().worst_deviation_mm), 1e-3);
    EXPECT_EQ(live.last_sample_host_time()->count(), samples.back().host_time_ns);
    EXPECT_DOUBLE_EQ(live.last_machine_time_s(), 2e-3 * static_cast<double>(samples.size()));
}

TEST_F(LiveSectionTest, ASectionOfUnknownLengthClosesWhenItIsTold) {
    const auto samples = samples_of(path, 1, 1);
    auto live = section(0);
    live.add(std::span(samples).first(20));
    EXPECT_FALSE(live.complete());
    live.close_after(21);
    EXPECT_FALSE(live.complete());
    live.add(std::span(samples).subspan(20, 1));
    EXPECT_TRUE(live.complete());
    EXPECT_EQ(live.snapshot().state, State::closed);
}

TEST_F(LiveSectionTest, PointsWithoutContactAreKeptButNotJudged) {
    auto samples = samples_of(path, 1, 1, 0.02);
    for (std::size_t i = 40; i < 50; ++i) {
        samples[i] = sample_at(samples[i].sequence, 1, path.points[i].centre_mm - 1.5 * path.points[i].normal);
        samples[i].flags = core::sample_flag::no_contact;
    }
    auto live = section(samples.size());
    live.add(samples);
    EXPECT_TRUE(live.complete());
    EXPECT_EQ(live.snapshot().no_contact, 10U);
    EXPECT_EQ(live.points()[45].verdict.reason, fitting::RejectReason::no_contact);
    EXPECT_EQ(live.points()[45].flags, core::sample_flag::no_contact);
    EXPECT_NEAR(*live.snapshot().worst_deviation_mm, 0.02, 1e-3);
}

TEST_F(LiveSectionTest, RunsOfUpToThreeBadPointsDoNotMoveTheWorstDeviation) {
    for (std::size_t count = 0; count <= 3; ++count)
        EXPECT_NEAR(worst(with_bad_run(30, count)), 0.02, 1e-3) << count;
    EXPECT_GT(worst(with_bad_run(30, 4)), 0.4);
}

TEST_F(LiveSectionTest, TheWorstDeviationKeepsItsSign) {
    EXPECT_NEAR(worst(samples_of(path, 1, 1, 0.03)), 0.03, 1e-3);
    EXPECT_NEAR(worst(samples_of(path, 1, 1, -0.03)), -0.03, 1e-3);
}

TEST_F(LiveSectionTest, RestoredPointsCountLikeMeasuredOnes) {
    const auto samples = samples_of(path, 1, 1, 0.02);
    auto whole = section(samples.size());
    whole.add(samples);
    const std::size_t cut = samples.size() / 3;
    auto before = section(samples.size());
    before.add(std::span(samples).first(cut));

    auto resumed = section(samples.size());
    resumed.restore(before.points());
    EXPECT_EQ(resumed.snapshot().points, cut);
    EXPECT_FALSE(resumed.last_sample_host_time());  // nothing came off the wire yet
    resumed.add(std::span(samples).subspan(cut));
    EXPECT_TRUE(resumed.complete());
    EXPECT_DOUBLE_EQ(resumed.snapshot().length_mm, whole.snapshot().length_mm);
    EXPECT_DOUBLE_EQ(*resumed.snapshot().worst_deviation_mm, *whole.snapshot().worst_deviation_mm);
}

TEST_F(LiveSectionTest, TellsWhereTheNextPointIsExpected) {
    const auto samples = samples_of(path, 1, 1);
    auto live = section(samples.size());
    live.add(std::span(samples).first(2));
    EXPECT_FALSE(live.snapshot().curve.valid);
    EXPECT_FALSE(live.snapshot().predicted.valid);
    live.add(std::span(samples).subspan(2, 38));
    const auto now = live.snapshot();
    ASSERT_TRUE(now.predicted.valid);
    EXPECT_GT(now.curve.normal.dot(path.points[39].normal.head<2>()), 0.9999);
    const Eigen::Vector2d apart = path.points[40].centre_mm.head<2>() - now.predicted.centre;
    EXPECT_LT(std::abs(apart.dot(now.predicted.normal)), 4.0 * now.predicted.sigma_mm + test_lsb_mm);
    EXPECT_LT(now.predicted.sigma_mm, 0.01);
    EXPECT_LT(now.noise_mm, 0.002);
}

/// Interrupted, taken up again, some samples twice, some late: the record and all that follows from it are the same.
TEST_F(LiveSectionTest, TheOrderOfArrivalDoesNotMatter) {
    const auto samples = samples_of(path, 1, 1, 0.02);
    auto ordered = section(samples.size());
    ordered.add(samples);
    for (const std::size_t overtaken : {std::size_t{3}, std::size_t{40}}) {
        auto first = section(samples.size());
        first.add(std::span(samples).first(90));
        auto live = section(samples.size());
        live.restore(first.points());
        for (std::size_t i = 80; i < samples.size(); i += overtaken) {
            const auto block = std::span(samples).subspan(i, std::min(overtaken, samples.size() - i));
            live.add(block.subspan(1));
            live.add(block.first(1));
            live.add(block.last(1));
        }
        ASSERT_EQ(live.points().size(), samples.size());
        EXPECT_TRUE(live.complete());
        const auto a = ordered.snapshot(), b = live.snapshot();
        EXPECT_EQ(a.curve.position, b.curve.position);
        EXPECT_EQ(a.curve.sigma_mm, b.curve.sigma_mm);
        EXPECT_EQ(a.predicted.centre, b.predicted.centre);
        EXPECT_EQ(a.noise_mm, b.noise_mm);
        EXPECT_NEAR(a.length_mm, b.length_mm, 1e-9);

        const auto whole = SectionJudge().finish(setup, ordered.points());
        const auto patched = SectionJudge().finish(setup, live.points());
        ASSERT_TRUE(whole.has_contour() && patched.has_contour());
        ASSERT_EQ(whole.fit->contour.size(), patched.fit->contour.size());
        for (std::size_t i = 0; i < whole.fit->contour.size(); ++i)
            ASSERT_EQ(whole.fit->contour[i].position_mm, patched.fit->contour[i].position_mm) << i;
    }
}

/// What was known while it was scanned does not enter the closed section: it is the fit of its points.
TEST_F(LiveSectionTest, TheClosedSectionIsTheFitOfItsPoints) {
    const auto samples = samples_of(path, 1, 1, 0.02);
    auto live = section(samples.size());
    live.add(samples);
    const auto closed = SectionJudge().finish(setup, live.points());
    std::vector<Eigen::Vector2d> centres;
    for (const auto& sample : samples)
        centres.push_back(core::centre_mm(sample, test_lsb_mm).head<2>());
    fitting::SectionOptions options;
    options.ball_radius_mm = setup.ball_radius_mm;
    options.le_hint = closed.fit->le_point_mm;
    options.te_hint = closed.fit->te_point_mm;
    const auto batch = fitting::fit_section(centres, {}, options);
    ASSERT_TRUE(batch && closed.has_contour());
    ASSERT_EQ(batch->contour.size(), closed.fit->contour.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < batch->contour.size(); ++i)
        worst = std::max(worst, (batch->contour[i].position_mm - closed.fit->contour[i].position_mm).norm());
    EXPECT_LE(worst, 1e-9);
}

TEST_F(LiveSectionTest, WithoutANominalThereIsNoDeviation) {
    setup.nominal.reset();
    auto live = section(0);
    live.add(samples_of(path, 1, 1));
    EXPECT_FALSE(live.snapshot().worst_deviation_mm);
    EXPECT_EQ(live.snapshot().points, path.points.size());
}

TEST_F(LiveSectionTest, PointsAreInThePartFrame) {
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.translate(Eigen::Vector3d(1.0, -2.0, 3.0));
    motion.rotate(Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitZ()));
    LiveSection live(setup, test_lsb_mm, core::PartFromMachine(motion), 0);
    live.add(std::vector{sample_at(1, 1, {10.0, 0.0, 5.0})});
    EXPECT_TRUE(live.snapshot().last_mm.isApprox(Eigen::Vector3d(1.0, 8.0, 8.0), 1e-9));
}

}  // namespace
}  // namespace cmm::acquisition
