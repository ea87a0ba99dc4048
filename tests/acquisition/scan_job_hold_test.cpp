// SPDX-License-Identifier: Apache-2.0
// The run waits at rest for what may pass by itself. Over a real wire: tests/system/hold_test.cpp.
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <future>
#include <memory>

#include "acquisition/run_results.hpp"
#include "tests/acquisition/scan_job_fixture.hpp"

namespace cmm::acquisition {
namespace {

struct HoldTest : ScanJobTest {
    /// The cause lasts for so many questions.
    void lasts(std::size_t questions, ErrorCode code = ErrorCode::machine_door) {
        machine.on_call = [this, questions, code](const std::string& call) {
            if (call != "clear_fault") return;
            machine.cut_after = 0;
            const std::size_t asked = machine.count(call);
            machine.fail_at = asked <= questions ? call : "";
            machine.fail_number = asked;
            machine.fail_code = code;
        };
    }
    void wait_s(const std::string& seconds) {
        text.replace(text.find("[scan]\n"), 7, "[scan]\nwait_s = " + seconds + "\n");
    }
    std::size_t events_of(const Ran& ran, EventKind kind) const {
        return static_cast<std::size_t>(
            std::count_if(ran.events.begin(), ran.events.end(), [kind](const auto& e) { return e.kind == kind; }));
    }
    void expect_all_measured_once(const Ran& ran) {
        ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
        EXPECT_TRUE(ran.outcome.result.complete);
        EXPECT_EQ(ran.outcome.samples, points());
        EXPECT_EQ(machine.delivered, points());
        ASSERT_EQ(ran.outcome.result.sections.size(), 2U);
        for (std::size_t i = 0; i < 2; ++i)
            EXPECT_EQ(ran.outcome.result.sections[i].points.size(), job.plan.paths[i].points.size());
        EXPECT_EQ(events_of(ran, EventKind::section_final), 2U);
        EXPECT_EQ(events_of(ran, EventKind::run_started), 1U);
        EXPECT_EQ(ran.find(EventKind::machine_fault), nullptr);
        EXPECT_TRUE(results_of_run(file, nullptr)->complete);
    }
};

TEST_F(HoldTest, ADoorThatOpensInTheMiddleOfASectionIsWaitedFor) {
    machine.cut_after = job.plan.paths[0].points.size() + 25;
    machine.cut_keeps = 5;
    machine.cut_code = ErrorCode::machine_door;
    lasts(2);
    std::vector<std::string> told;
    with_job = [&told](ScanJob& scan) { scan.on_notice([&told](const std::string& line) { told.push_back(line); }); };
    const auto ran = run();
    expect_all_measured_once(ran);
    ASSERT_EQ(events_of(ran, EventKind::hold), 1U);
    const auto& hold = *ran.find(EventKind::hold);
    EXPECT_TRUE(holds(hold.payload, "\"code\":\"machine_door\"")) << hold.payload;
    EXPECT_TRUE(holds(hold.payload, "\"section\":1,\"wait_s\":300.0")) << hold.payload;
    EXPECT_EQ(events_of(ran, EventKind::resume), 1U);
    EXPECT_EQ(machine.count("home"), 1U);
    EXPECT_EQ(machine.count("qualify"), 1U);
    EXPECT_EQ(machine.count("scan"), 3U);
    ASSERT_EQ(told.size(), 2U);
    EXPECT_TRUE(holds(told[0], "waiting at rest, up to 300 s")) << told[0];
}

struct DiskHoldTest : HoldTest, ::testing::WithParamInterface<ErrorCode> {};

TEST_P(DiskHoldTest, InTheMiddleOfASectionTheDiskIsWaitedFor) {
    machine.cut_after = job.plan.paths[0].points.size() + 25;
    machine.cut_keeps = 5;
    machine.cut_code = GetParam();
    lasts(0);
    const auto ran = run();
    expect_all_measured_once(ran);
    EXPECT_EQ(events_of(ran, EventKind::hold), 1U);
    EXPECT_EQ(events_of(ran, EventKind::resume), 1U);
    // What happened before and after the waiting is in the run file.
    const auto journal = Journal::read(file);
    ASSERT_TRUE(journal) << journal.error().text();
    std::string kept;
    const auto keep = [&kept](std::uint64_t, std::string_view line) {
        kept += line;
        return core::Status{};
    };
    ASSERT_TRUE((*journal)->each_event(1, keep));
    for (const auto* event : {"\"RunStarted\"", "\"Hold\"", "\"RunStopped\""})
        EXPECT_TRUE(holds(kept, event)) << event;
}

INSTANTIATE_TEST_SUITE_P(Disks, DiskHoldTest, ::testing::Values(ErrorCode::journal_full, ErrorCode::journal_slow),
                         [](const auto& disk) { return std::string(disk.index == 0 ? "Full" : "Slow"); });

/// A disk that is full and does not even answer how full, until the test lets it.
struct DyingDiskTest : HoldTest {
    DyingDiskTest() {
        machine.cut_after = job.plan.paths[0].points.size() + 25;
        machine.cut_code = ErrorCode::journal_full;
        disk_has_room = [when = answer.get_future().share(), asked = asked](const std::string&, std::int64_t) {
            ++*asked;
            return when.get();
        };
    }
    std::promise<bool> answer;
    std::shared_ptr<std::atomic<int>> asked = std::make_shared<std::atomic<int>>(0);
};

TEST_F(DyingDiskTest, AStopRequestIsHeardMeanwhile) {
    with_job = [this](ScanJob& scan) {
        machine.on_call = [this, &scan, looks = 0](const std::string& call) mutable {
            // The machine is looked after while the disk is asked.
            if (call == "state" && *asked > 0 && ++looks == 3) scan.request_stop();
        };
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::cancelled) << ran.outcome.error->text();
    EXPECT_EQ(machine.calls.back(), "end_run");
    EXPECT_EQ(*asked, 1);
    answer.set_value(false);
}

TEST_F(DyingDiskTest, TheTimeOfWaitingEndsAllTheSame) {
    wait_s("0.6");
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::journal_full) << ran.outcome.error->text();
    EXPECT_EQ(*asked, 1);
    answer.set_value(false);
}

TEST_F(DyingDiskTest, TheRunGoesOnWhenItAnswers) {
    machine.on_call = [this, looks = 0](const std::string& call) mutable {
        if (call != "state" || *asked == 0 || ++looks != 3) return;
        machine.cut_after = 0;
        answer.set_value(true);
    };
    expect_all_measured_once(run());
    EXPECT_EQ(*asked, 1);
}

TEST_F(HoldTest, ATemperatureBeforeTheFirstMotionIsWaitedFor) {
    machine.fail_at = "home";
    machine.fail_code = ErrorCode::machine_temperature;
    lasts(1, ErrorCode::machine_temperature);
    const auto ran = run();
    expect_all_measured_once(ran);
    EXPECT_EQ(machine.count("qualify"), 1U);
}

TEST_F(HoldTest, AStopOfBeforeWithTheDoorOpenIsWaitedForToo) {
    machine.status.state = drivers::MachineState::stopped;
    lasts(2);
    const auto ran = run();
    expect_all_measured_once(ran);
}

TEST_F(HoldTest, AFaultAfterTheLastSampleOfASectionMeasuresNothingTwice) {
    machine.fail_at = "retract";
    machine.fail_code = ErrorCode::machine_door;
    lasts(0);
    const auto ran = run();
    expect_all_measured_once(ran);
    EXPECT_EQ(machine.count("scan"), 2U);
}

TEST_F(HoldTest, ItEndsWithTheReasonWhenTheTimeIsOver) {
    wait_s("0.6");
    machine.fail_at = "move";
    machine.fail_number = 3;
    machine.fail_code = ErrorCode::machine_door;
    lasts(1000);
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_door);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "(waited ")) << ran.outcome.error->text();
    EXPECT_NE(ran.find(EventKind::machine_fault), nullptr);
    EXPECT_GE(machine.stops, 1U);
    EXPECT_EQ(machine.calls.back(), "end_run");
}

TEST_F(HoldTest, NoTimeMeansNoWaiting) {
    wait_s("0");
    machine.fail_at = "move";
    machine.fail_code = ErrorCode::machine_door;
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_door);
    EXPECT_EQ(ran.find(EventKind::hold), nullptr);
    EXPECT_EQ(machine.count("clear_fault"), 0U);
}

TEST_F(HoldTest, AStopRequestEndsTheWaiting) {
    machine.fail_at = "move";
    machine.fail_code = ErrorCode::machine_door;
    lasts(1000);
    with_job = [this](ScanJob& scan) {
        machine.on_call = [this, &scan, before = machine.on_call](const std::string& call) {
            before(call);
            if (call == "clear_fault") scan.request_stop();
        };
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::cancelled);
    EXPECT_EQ(machine.count("clear_fault"), 1U);
    EXPECT_EQ(machine.calls.back(), "end_run");
}

TEST_F(HoldTest, AnEmergencyStopMeanwhileIsNotWaitedFor) {
    machine.fail_at = "move";
    machine.fail_code = ErrorCode::machine_door;
    lasts(1000, ErrorCode::machine_emergency);
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_emergency);
    EXPECT_EQ(machine.count("clear_fault"), 1U);
}

TEST_F(HoldTest, OtherFaultsEndTheRunAtOnce) {
    for (const auto code : {ErrorCode::machine_position, ErrorCode::machine_emergency, ErrorCode::machine_limit}) {
        std::filesystem::remove(file);
        forget();
        machine.fail_at = "move";
        machine.fail_number = 1;
        machine.fail_code = code;
        const auto ran = run();
        ASSERT_TRUE(ran.outcome.error);
        EXPECT_EQ(ran.outcome.error->code, code);
        EXPECT_EQ(ran.find(EventKind::hold), nullptr);
    }
}

}  // namespace
}  // namespace cmm::acquisition
