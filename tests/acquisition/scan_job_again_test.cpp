// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "acquisition/run_results.hpp"
#include "core/rng.hpp"
#include "tests/acquisition/scan_job_fixture.hpp"

namespace cmm::acquisition {
namespace {

constexpr double noise_mm = 0.002;

/// A blade whose lower section swells on one side to a share of what its zone allows. What is touched depends on the
/// place alone, so that a run that was cut off finds the same part.
struct UntilDecidedTest : ScanJobTest {
    double share = 0.99;
    Eigen::Vector2d top_mm = Eigen::Vector2d::Zero();
    decltype(machine.contact) touched;

    void SetUp() override {
        text = session_part_text("0.4");
        text.replace(text.find("[scan]\n"), 7, "[scan]\nuntil_decided = true\nextra_passes = 2\n");
        text.replace(text.find("[gate]\n"), 7, "[fitting]\ncompensation = \"2d\"\n[gate]\n");
        // A prism: the 2-D offset is right there.
        for (const auto& [from, to] : {std::pair{"chord_tip_mm = 25", "chord_tip_mm = 30"},
                                       {"thickness_tip_mm = 2.5", "thickness_tip_mm = 3"},
                                       {"stagger_tip_deg = 28", "stagger_tip_deg = 20"},
                                       {"lean_x_deg = 2", "lean_x_deg = 0"},
                                       {"lean_y_deg = -3", "lean_y_deg = 0"}})
            text.replace(text.find(from), std::string(from).size(), to);
        job = SessionPart(text);
        const auto& lap = job.plan.paths[0].points;
        top_mm = lap[lap.size() / 8].centre_mm.head<2>();
        touched = [this](const drivers::PathPoint& point) {
            auto rng = core::Rng::keyed(static_cast<std::uint64_t>(std::llround(1e5 * (500.0 + point.centre_mm.x()))),
                                        static_cast<std::uint64_t>(std::llround(1e5 * (500.0 + point.centre_mm.y()))),
                                        static_cast<std::uint64_t>(std::llround(1e3 * point.centre_mm.z())));
            const double off_top = (point.centre_mm.head<2>() - top_mm).norm() / 3.0;
            const double swollen = point.centre_mm.z() < 30.0 ? share * 0.05 * std::exp(-0.5 * off_top * off_top) : 0.0;
            return std::optional<Eigen::Vector3d>(point.centre_mm + (swollen + noise_mm * rng.normal()) * point.normal);
        };
        machine.contact = touched;
    }
    std::size_t planned(std::size_t section) const { return job.plan.paths[section].points.size(); }
    std::size_t laps() const { return planned(0) + planned(1); }
    static std::size_t again(const SectionResult& section) {
        return static_cast<std::size_t>(std::count_if(section.points.begin(), section.points.end(),
                                                      [](const RecordedPoint& point) { return point.pass > 0; }));
    }
    static std::size_t count(const Ran& ran, EventKind kind) {
        return static_cast<std::size_t>(std::count_if(ran.events.begin(), ran.events.end(),
                                                      [&](const Event& event) { return event.kind == kind; }));
    }
    static void expect_same(const PartResult& one, const PartResult& other) {
        ASSERT_EQ(one.sections.size(), other.sections.size());
        for (std::size_t i = 0; i < one.sections.size(); ++i) {
            const auto &a = one.sections[i], &b = other.sections[i];
            ASSERT_EQ(a.points.size(), b.points.size()) << i;
            ASSERT_TRUE(a.fit && b.fit);
            ASSERT_EQ(a.fit->contour.size(), b.fit->contour.size());
            for (std::size_t k = 0; k < a.fit->contour.size(); ++k)
                ASSERT_EQ(a.fit->contour[k].position_mm, b.fit->contour[k].position_mm);
            ASSERT_EQ(a.characteristics.size(), b.characteristics.size());
            for (std::size_t k = 0; k < a.characteristics.size(); ++k) {
                EXPECT_EQ(a.characteristics[k].decision, b.characteristics[k].decision);
                EXPECT_EQ(a.characteristics[k].value, b.characteristics[k].value);
            }
        }
    }
    PartResult unbroken() {
        const auto ran = run();
        EXPECT_FALSE(ran.outcome.error) << ran.outcome.error->text();
        std::filesystem::remove(file);
        forget();
        return ran.outcome.result;
    }
    std::optional<std::size_t> pass_of_last_path() const {
        const auto journal = Journal::read(file);
        if (!journal) return std::nullopt;
        const auto paths = (*journal)->paths();
        return paths && !paths->empty() ? std::optional<std::size_t>(paths->back().pass) : std::nullopt;
    }
};

TEST_F(UntilDecidedTest, AnUndecidedSectionIsMeasuredAgainWhereItMatters) {
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    const auto& result = ran.outcome.result;
    EXPECT_TRUE(result.complete);
    ASSERT_EQ(result.sections.size(), 2U);
    EXPECT_GT(again(result.sections[0]), 10U);
    EXPECT_EQ(again(result.sections[1]), 0U) << "it is decided";
    for (const auto& point : result.sections[0].points) {
        if (point.pass > 0) {
            EXPECT_LT((point.centre_mm.head<2>() - top_mm).norm(), 12.0);
        }
    }
    EXPECT_EQ(result.verdict(), Decision::accept) << verdict_reasons(result).at(0);
    const Event* event = ran.find(EventKind::measure_again);
    ASSERT_NE(event, nullptr);
    EXPECT_TRUE(holds(event->payload, "\"section\":0")) << event->payload;
    EXPECT_TRUE(holds(event->payload, "\"because\":[{\"name\":\"profile_")) << event->payload;
    EXPECT_EQ(pass_of_last_path(), std::optional<std::size_t>(result.sections[0].points.back().pass));
    EXPECT_TRUE(holds(result.decision_rule, "up to 3 looks")) << result.decision_rule;
    // The run file alone says the same.
    const auto later = results_of_run(file, nullptr);
    ASSERT_TRUE(later) << later.error().text();
    EXPECT_TRUE(later->complete);
    EXPECT_EQ(later->decision_rule, result.decision_rule);
    expect_same(result, *later);
}

TEST_F(UntilDecidedTest, NothingIsMeasuredAgainOfAPartThatIsDecided) {
    share = 0.2;
    const auto good = run();
    EXPECT_EQ(good.outcome.result.verdict(), Decision::accept);
    EXPECT_EQ(good.outcome.samples, laps());
    EXPECT_EQ(good.find(EventKind::measure_again), nullptr);
    std::filesystem::remove(file);
    forget();
    share = 1.6;
    const auto bad = run();
    EXPECT_EQ(bad.outcome.result.verdict(), Decision::reject);
    EXPECT_EQ(bad.outcome.samples, laps());
}

TEST_F(UntilDecidedTest, WithoutBeingAskedForASectionEndsUndecided) {
    share = 0.995;
    text.replace(text.find("until_decided = true\nextra_passes = 2\n"), 38, "");
    const auto ran = run();
    EXPECT_EQ(ran.outcome.result.sections[0].decision(), Decision::undecided);
    EXPECT_EQ(ran.outcome.samples, laps());
}

TEST_F(UntilDecidedTest, ARunThatLosesItsLinkInAPassGoesOnBehindItsLastPoint) {
    const auto whole = unbroken();
    const std::size_t extra = again(whole.sections[0]);
    for (const std::size_t into : {std::size_t{1}, extra / 2, extra - 3}) {
        machine.cut_after = machine.delivered + laps() + into;
        machine.cut_keeps = 2;
        const auto broken = run();
        ASSERT_TRUE(broken.outcome.error) << into;
        EXPECT_EQ(broken.outcome.error->code, ErrorCode::transport_closed);
        EXPECT_EQ(durable(), laps() + into);
        EXPECT_FALSE(broken.outcome.result.complete);
        forget();
        machine.cut_after = 0;
        ASSERT_EQ(pass_of_last_path(), std::optional<std::size_t>(1U));
        const auto ran = run(true);
        ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
        EXPECT_TRUE(ran.outcome.result.complete);
        expect_same(whole, ran.outcome.result);
        const auto later = results_of_run(file, nullptr);
        ASSERT_TRUE(later) << later.error().text();
        expect_same(whole, *later);
        std::filesystem::remove(file);
        forget();
    }
}

TEST_F(UntilDecidedTest, AStopInAPassStopsTheMachineAndKeepsItsPoints) {
    const auto whole = unbroken();
    const std::size_t stop_at = machine.delivered + laps() + 7;
    with_job = [&](ScanJob& scan) {
        machine.on_scanned = [&scan, stop_at](std::size_t scanned) {
            if (scanned == stop_at) scan.request_stop();
        };
    };
    const auto stopped = run();
    ASSERT_TRUE(stopped.outcome.error);
    EXPECT_EQ(stopped.outcome.error->code, ErrorCode::cancelled);
    EXPECT_GE(machine.stops, 1U);
    EXPECT_EQ(machine.calls.back(), "end_run");
    EXPECT_FALSE(stopped.outcome.result.complete);
    EXPECT_EQ(again(stopped.outcome.result.sections[0]), 7U);
    const auto so_far = results_of_run(file, nullptr);
    ASSERT_TRUE(so_far);
    expect_same(stopped.outcome.result, *so_far);
    with_job = {};
    machine.on_scanned = {};
    machine.status.state = drivers::MachineState::idle;
    const auto resumed = run(true);
    ASSERT_FALSE(resumed.outcome.error) << resumed.outcome.error->text();
    expect_same(whole, resumed.outcome.result);
}

/// A blade that is good, of whose lower section the probe did not feel the part near a place when it came there for the
/// first time.
struct GapAgainTest : UntilDecidedTest {
    std::set<std::pair<long, long>> seen;
    double reach_mm = 2.5;
    Eigen::Vector2d le_mm = Eigen::Vector2d::Zero(), side_mm = Eigen::Vector2d::Zero();

    void SetUp() override {
        UntilDecidedTest::SetUp();
        share = 0.2;
        const auto& lap = job.plan.paths[0].points;
        const auto more_left = [](const auto& a, const auto& b) { return a.centre_mm.x() < b.centre_mm.x(); };
        le_mm = std::min_element(lap.begin(), lap.end(), more_left)->centre_mm.head<2>();
        side_mm = lap[lap.size() / 3].centre_mm.head<2>();
    }
    void lose_first_touches_at(const Eigen::Vector2d& lost_mm) {
        seen.clear();
        machine.contact = [this, touched = touched, lost_mm](const drivers::PathPoint& point) {
            const auto at = point.centre_mm.head<2>();
            const bool first = seen.emplace(std::lround(1e3 * at.x()), std::lround(1e3 * at.y())).second;
            const bool lost = first && point.centre_mm.z() < 30.0 && (at - lost_mm).norm() < reach_mm;
            return lost ? std::nullopt : touched(point);
        };
    }
    std::size_t lost_near(const Eigen::Vector2d& lost_mm) const {
        const auto& lap = job.plan.paths[0].points;
        std::set<std::pair<double, double>> places;  // the lap passes its start
        for (const auto& point : lap)
            if ((point.centre_mm.head<2>() - lost_mm).norm() < reach_mm)
                places.emplace(point.centre_mm.x(), point.centre_mm.y());
        return places.size();
    }
};

TEST_F(GapAgainTest, WhatTheProbeMissedIsMeasuredAgain) {
    for (const auto& [lost_mm, far_mm] : {std::pair{le_mm, 2.5}, {le_mm, 7.0}, {side_mm, 2.5}}) {
        reach_mm = far_mm;
        lose_first_touches_at(lost_mm);
        const auto ran = run();
        ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
        const SectionResult& section = ran.outcome.result.sections[0];
        EXPECT_EQ(again(section), lost_near(lost_mm));
        EXPECT_TRUE(section.gaps().empty());
        EXPECT_TRUE(section.all_round()) << section.why_not_all_round();
        EXPECT_EQ(ran.outcome.result.verdict(), Decision::accept) << verdict_reasons(ran.outcome.result).at(0);
        for (const auto& d : section.deviation_mm)
            if (d) {
                EXPECT_LT(std::abs(*d), 0.03);
            }
        const Event* event = ran.find(EventKind::measure_again);
        ASSERT_NE(event, nullptr);
        EXPECT_TRUE(holds(event->payload, "\"because\":[{\"name\":\"profile_")) << event->payload;
        EXPECT_TRUE(holds(event->payload, "\"points\":" + std::to_string(lost_near(lost_mm)) + ",")) << event->payload;
        const auto later = results_of_run(file, nullptr);
        ASSERT_TRUE(later) << later.error().text();
        expect_same(ran.outcome.result, *later);
        std::filesystem::remove(file);
        forget();
    }
}

/// Also where nothing has limits: a part that is measured in part is not done.
TEST_F(GapAgainTest, NothingNeedHaveLimits) {
    for (const std::string limit : {"profile_mm = 0.1\n", "edge_profile_mm = 0.1\n"})
        text.erase(text.find(limit), limit.size());
    job = SessionPart(text);
    lose_first_touches_at(le_mm);
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(again(ran.outcome.result.sections[0]), lost_near(le_mm));
    EXPECT_EQ(ran.outcome.result.sections[0].decision(), Decision::reported);
    EXPECT_NE(ran.outcome.result.verdict(), Decision::undecided);
}

/// What it does not feel a second time either stays a gap, after the passes that are allowed.
TEST_F(GapAgainTest, WhatCannotBeTouchedStaysAGap) {
    machine.contact = [this, touched = touched](const drivers::PathPoint& point) {
        const bool lost = point.centre_mm.z() < 30.0 && (point.centre_mm.head<2>() - side_mm).norm() < reach_mm;
        return lost ? std::nullopt : touched(point);
    };
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    const SectionResult& section = ran.outcome.result.sections[0];
    EXPECT_EQ(again(section), 2 * lost_near(side_mm)) << "two passes";
    EXPECT_EQ(section.gaps().size(), 1U);
    EXPECT_EQ(section.decision(), Decision::undecided);
    EXPECT_EQ(ran.outcome.result.verdict(), Decision::undecided);
}

TEST_F(GapAgainTest, ARunThatLosesItsLinkInAGapGoesOnBehindItsLastPoint) {
    lose_first_touches_at(le_mm);
    const auto whole = unbroken();
    lose_first_touches_at(le_mm);
    machine.cut_after = machine.delivered + laps() + 4;
    machine.cut_keeps = 2;
    ASSERT_TRUE(run().outcome.error);
    forget();
    machine.cut_after = 0;
    const auto ran = run(true);
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(again(ran.outcome.result.sections[0]), lost_near(le_mm));
    EXPECT_EQ(ran.outcome.result.verdict(), whole.verdict());
}

/// A door that is opened in a pass: the job waits at rest, and goes on in the same process.
TEST_F(UntilDecidedTest, ADoorThatIsOpenedInAPassHoldsItUp) {
    const auto whole = unbroken();
    machine.cut_after = machine.delivered + laps() + 9;
    machine.cut_keeps = 2;
    machine.cut_code = ErrorCode::machine_door;
    machine.on_call = [this](const std::string& call) {
        if (call == "clear_fault") machine.cut_after = 0;
    };
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(count(ran, EventKind::hold), 1U);
    EXPECT_TRUE(ran.outcome.result.complete);
    expect_same(whole, ran.outcome.result);
}

}  // namespace
}  // namespace cmm::acquisition
