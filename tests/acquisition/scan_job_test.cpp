// SPDX-License-Identifier: Apache-2.0
#include "acquisition/scan_job.hpp"

#include <array>
#include <filesystem>

#include "acquisition/clearance.hpp"
#include "acquisition/run_results.hpp"
#include "core/text.hpp"
#include "tests/acquisition/outline_contact.hpp"
#include "tests/acquisition/scan_job_fixture.hpp"

namespace cmm::acquisition {
namespace {

TEST_F(ScanJobTest, AStopThatAnotherRunEndedWithIsNotInTheWayOfANewOne) {
    for (const auto state :
         {drivers::MachineState::stopped, drivers::MachineState::fault, drivers::MachineState::emergency}) {
        std::filesystem::remove(file);
        machine.status.state = state;
        const auto ran = run();
        ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
        EXPECT_EQ(machine.count("clear_fault"), 1U);
        forget();
    }
}

TEST_F(ScanJobTest, ANewRunLeavesThePartOnWhichAnotherOneStopped) {
    const OutlineContact part{job};
    const auto& places = job.plan.paths[1].points;
    for (std::size_t i = 0; i < places.size(); i += 2) {
        std::filesystem::remove(file);
        forget();
        machine.status.homed = true;
        machine.status.state = drivers::MachineState::stopped;
        machine.status.position_mm = places[i].centre_mm;
        machine.fail_at = "scan";
        Eigen::Vector3d from = places[i].centre_mm;
        ASSERT_TRUE(run().outcome.error);
        ASSERT_GT(machine.moves.size(), 1U) << i;
        const Eigen::Vector3d clear = places[i].centre_mm + job.plan.approach_mm * places[i].normal;
        EXPECT_LT((machine.moves[0] - clear).norm(), 0.02) << i;
        for (const auto& to : machine.moves) {
            for (double share = 0.0; share <= 1.0; share += 0.01)
                EXPECT_GT(part.gap_mm(from + share * (to - from)), -1e-3)
                    << i << ", " << share << " of the way to " << to.transpose();
            from = to;
        }
    }
}

TEST_F(ScanJobTest, AStopRequestBeforeANewRunLeavesThePartMovesNothing) {
    for (const std::size_t state : {1U, 2U, 3U}) {  // each time it is asked for: before and after the fault was cleared
        std::filesystem::remove(file);
        forget();
        machine.status.homed = true;
        machine.status.state = drivers::MachineState::stopped;
        machine.status.position_mm = job.plan.paths[1].points[7].centre_mm;
        with_job = [&](ScanJob& scan) {
            machine.on_call = [&](const std::string& call) {
                if (call == "clear_fault" || (call == "state" && machine.count("state") == state)) scan.request_stop();
            };
        };
        const auto ran = run();
        ASSERT_TRUE(ran.outcome.error) << state;
        EXPECT_EQ(ran.outcome.error->code, ErrorCode::cancelled);
        EXPECT_TRUE(machine.moves.empty()) << state;
        EXPECT_EQ(machine.count("home") + machine.count("qualify"), 0U);
    }
}

TEST_F(ScanJobTest, MeasuresAndJudgesEverySection) {
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    const auto& result = ran.outcome.result;
    EXPECT_TRUE(result.complete);
    EXPECT_EQ(result.verdict(), Decision::accept);
    EXPECT_EQ(result.run_id, "run-1");
    EXPECT_EQ(result.machine, "Fake 1 (test:)");
    ASSERT_EQ(result.sections.size(), 2U);
    for (const auto& section : result.sections)
        EXPECT_TRUE(section.has_contour()) << section.why;
    EXPECT_EQ(ran.outcome.samples, points());
    EXPECT_EQ(ran.outcome.latency.closed.count, 2U);
    EXPECT_EQ(ran.outcome.latency.decided.count, 2U);
    EXPECT_EQ(machine.count("home"), 1U);
    EXPECT_EQ(machine.count("qualify"), 1U);
    EXPECT_EQ(machine.count("scan"), 2U);
    EXPECT_EQ(machine.stops, 0U);
    EXPECT_EQ(machine.calls.back(), "end_run");

    ASSERT_FALSE(ran.events.empty());
    EXPECT_EQ(ran.events.front().kind, EventKind::run_started);
    EXPECT_EQ(ran.events.back().kind, EventKind::run_stopped);
    EXPECT_TRUE(holds(ran.events.back().payload, "\"verdict\":\"accept\",\"complete\":true"))
        << ran.events.back().payload;
    EXPECT_EQ(ran.find(EventKind::machine_fault), nullptr);
    for (std::size_t i = 0; i < ran.events.size(); ++i)
        EXPECT_EQ(ran.events[i].seq, i + 1);

    const auto journal = Journal::read(file);
    ASSERT_TRUE(journal) << journal.error().text();
    EXPECT_EQ((*journal)->samples()->size(), points());
    EXPECT_EQ((*journal)->verdict().value(), "accept");
    const auto again = results_of_run(file, nullptr);
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_TRUE(again->complete);
    for (std::size_t i = 0; i < 2; ++i) {
        const auto& live = result.sections[i].fit->contour;
        const auto& later = again->sections[i].fit->contour;
        ASSERT_EQ(live.size(), later.size());
        for (std::size_t k = 0; k < live.size(); ++k)
            EXPECT_EQ(live[k].position_mm, later[k].position_mm);
    }
}

/// Who judges the run later does not have the machine's file, and a machine that goes on may have another one.
TEST_F(ScanJobTest, WhatTheMachineMayErrByIsKeptWithTheRun) {
    machine_errors.length_mm = 1.9e-3;
    machine_errors.probing_size_mm = 1.5e-3;
    text += "[uncertainty]\nprobing_form_um = 1.2\n";
    broken_run(points() / 2, points() / 2);
    machine_errors.length_mm = 9e-3;
    const auto ran = run(true);
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    const auto& live = ran.outcome.result;
    EXPECT_EQ(live.uncertainty.figures().length_mm, 1.9e-3);
    EXPECT_EQ(live.uncertainty.figures().probing_form_mm, 1.2e-3);
    const auto again = results_of_run(file, nullptr);
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(again->uncertainty.figures(), live.uncertainty.figures());
    for (std::size_t i = 0; i < 2; ++i) {
        for (const auto& c : live.sections[i].characteristics) {
            ASSERT_TRUE(c.budget) << c.name;
            EXPECT_GT(c.budget->of(fitting::ErrorSource::ball), 0.0) << c.name;
            EXPECT_GT(c.budget->of(fitting::ErrorSource::probing), 0.0) << c.name;
            EXPECT_GT(c.budget->of(fitting::ErrorSource::length), 0.0) << c.name;
            EXPECT_EQ(again->sections[i].find(c.name)->u95, c.u95) << c.name;
        }
    }
    // Another part file may know better.
    auto better = parse_part_file(text + "length_um = 0.5\n", "better.toml").value();
    const auto judged = results_of_run(file, &better);
    ASSERT_TRUE(judged) << judged.error().text();
    EXPECT_LT(*judged->sections[0].find("chord")->u95, *live.sections[0].find("chord")->u95);
}

TEST_F(ScanJobTest, TellsWhatNeedsSeveralSectionsBeforeItEnds) {
    text += "[[characteristic]]\nname = \"lean_x\"\n[[characteristic]]\nname = \"relative_twist\"\n";
    const auto ran = run();
    const auto& said = ran.outcome.result.characteristics;
    ASSERT_EQ(said.size(), 2U);
    std::vector<std::string> told;
    for (const auto& event : ran.events)
        if (event.kind == EventKind::characteristic_updated && holds(event.payload, "\"of_part\":true"))
            told.push_back(event.payload);
    ASSERT_EQ(told.size(), 2U);
    EXPECT_TRUE(holds(told[0], "\"section\":null")) << told[0];
    EXPECT_TRUE(holds(told[0], "\"name\":\"lean_x\"")) << told[0];
    EXPECT_TRUE(holds(told[0], "\"value\":" + core::fixed(*said[0].number.value, 9))) << told[0];
    EXPECT_TRUE(holds(told[1], "\"section\":1,")) << told[1];
    EXPECT_EQ(ran.events.back().kind, EventKind::run_stopped);
}

TEST_F(ScanJobTest, ABadPartIsRejected) {
    machine.contact = [](const drivers::PathPoint& point) {
        return std::optional<Eigen::Vector3d>(point.centre_mm + 0.2 * point.normal);
    };
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(ran.outcome.result.verdict(), Decision::reject);
}

TEST_F(ScanJobTest, ABadPartEndsTheRunOnRequestAsSoonAsThatIsCertain) {
    machine.contact = [](const drivers::PathPoint& point) {
        return std::optional<Eigen::Vector3d>(point.centre_mm + 0.2 * point.normal);
    };
    text = session_part_text("0.05");  // many more points than are sent ahead
    text.replace(text.find("[scan]\n"), 7, "[scan]\nstop_when_rejected = true\n");
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    const auto& result = ran.outcome.result;
    EXPECT_EQ(result.verdict(), Decision::reject);
    EXPECT_FALSE(result.complete);
    EXPECT_TRUE(holds(verdict_reasons(result).at(0), "profile_")) << verdict_reasons(result).at(0);
    ASSERT_EQ(result.sections.size(), 1U);
    EXPECT_FALSE(result.sections[0].all_round());
    EXPECT_LT(ran.outcome.samples, 600U);
    EXPECT_EQ(machine.count("scan"), 1U);
    EXPECT_EQ(machine.count("retract"), 1U);
    EXPECT_EQ(machine.stops, 0U);
    EXPECT_EQ(machine.calls.back(), "end_run");
    const Event* decided = ran.find(EventKind::gate_decision);
    ASSERT_NE(decided, nullptr);
    EXPECT_TRUE(holds(decided->payload, "\"section\":0,\"decision\":\"reject\",\"while_measuring\":true"))
        << decided->payload;
    const auto journal = Journal::read(file);
    ASSERT_TRUE(journal) << journal.error().text();
    EXPECT_EQ((*journal)->verdict().value(), "reject");
    const auto again = results_of_run(file, nullptr);
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(again->verdict(), Decision::reject);
    EXPECT_FALSE(again->complete);
}

TEST_F(ScanJobTest, AGoodPartIsMeasuredToItsEndAlsoThen) {
    text = session_part_text("0.05");
    const auto plain = run();
    std::filesystem::remove(file);
    forget();
    text.replace(text.find("[scan]\n"), 7, "[scan]\nstop_when_rejected = true\n");
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(ran.outcome.result.verdict(), Decision::accept);
    EXPECT_TRUE(ran.outcome.result.complete);
    EXPECT_EQ(ran.outcome.samples, plain.outcome.samples);
}

struct FailingCall {
    const char* call;
    std::size_t number;
    bool owner;  ///< whether the job owns the machine by then
};

struct FailingCallTest : ScanJobTest, ::testing::WithParamInterface<FailingCall> {};

TEST_P(FailingCallTest, StopsTheMachineAndKeepsWhatWasMeasured) {
    const auto& at = GetParam();
    machine.fail_at = at.call;
    machine.fail_number = at.number;
    machine.fail_code = ErrorCode::machine_fault;
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_fault);
    EXPECT_TRUE(holds(ran.outcome.error->text(), at.call + std::string(" failed"))) << ran.outcome.error->text();
    EXPECT_FALSE(ran.outcome.result.complete);
    EXPECT_NE(ran.outcome.result.verdict(), Decision::accept);
    EXPECT_EQ(machine.stops, 1U);
    EXPECT_EQ(machine.count("end_run"), at.owner ? 1U : 0U);
    EXPECT_EQ(ran.outcome.samples, machine.delivered);
    ASSERT_NE(ran.find(EventKind::machine_fault), nullptr);
    EXPECT_EQ(ran.events.back().kind, EventKind::run_stopped);
    EXPECT_TRUE(holds(ran.events.back().payload, "\"complete\":false"));
    if (!at.owner) return;
    EXPECT_EQ(durable(), machine.delivered);
    EXPECT_EQ(Journal::read(file).value()->verdict().value(), "");
}

INSTANTIATE_TEST_SUITE_P(ScanJob, FailingCallTest,
                         ::testing::Values(FailingCall{"connect", 1, false}, FailingCall{"begin_run", 1, false},
                                           FailingCall{"state", 1, true}, FailingCall{"home", 1, true},
                                           FailingCall{"qualify", 1, true}, FailingCall{"move", 1, true},
                                           FailingCall{"move", 3, true}, FailingCall{"scan", 1, true},
                                           FailingCall{"retract", 1, true}, FailingCall{"scan", 2, true},
                                           FailingCall{"retract", 2, true}),
                         [](const auto& at) { return std::string(at.param.call) + std::to_string(at.param.number); });

TEST_F(ScanJobTest, TheFaultTellsWhereItHappened) {
    machine.fail_at = "retract";
    machine.fail_number = 2;
    const auto ran = run();
    const auto* fault = ran.find(EventKind::machine_fault);
    ASSERT_NE(fault, nullptr);
    for (const auto* part :
         {"\"state\":\"scanning\"", "\"section\":1", "\"path\":2", "while scanning section 1 (z 40.000 mm)"})
        EXPECT_TRUE(holds(fault->payload, part)) << fault->payload;
}

TEST_F(ScanJobTest, AMachineThatStillMovesAfterTheStopIsReported) {
    machine.fail_at = "scan";
    machine.status.in_motion = true;
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "scan failed"));  // the first failure is the one to repair
    const auto& last = *std::find_if(ran.events.rbegin(), ran.events.rend(),
                                     [](const Event& event) { return event.kind == EventKind::machine_fault; });
    EXPECT_TRUE(holds(last.payload, "may_be_moving")) << last.payload;
    EXPECT_EQ(machine.calls.back(), "end_run");
}

TEST_F(ScanJobTest, AStopRequestEndsTheScanUnderWay) {
    with_job = [this](ScanJob& scan) {
        machine.on_scanned = [&scan](std::size_t scanned) {
            if (scanned == 40) scan.request_stop();
        };
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::cancelled);
    EXPECT_GE(machine.stops, 1U);
    EXPECT_EQ(machine.count("scan"), 1U);
    EXPECT_EQ(machine.calls.back(), "end_run");
    EXPECT_EQ(durable(), 40U);
    ASSERT_EQ(ran.outcome.result.sections.size(), 1U);  // what was measured until then
    EXPECT_EQ(ran.outcome.result.sections[0].points.size(), 40U);
    EXPECT_FALSE(ran.outcome.result.complete);
}

TEST_F(ScanJobTest, AStopRequestBetweenTheStepsStartsNoOther) {
    with_job = [this](ScanJob& scan) {
        machine.on_call = [&scan](const std::string& call) {
            if (call == "home") scan.request_stop();
        };
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::cancelled);
    EXPECT_EQ(machine.count("qualify"), 0U);
    EXPECT_EQ(machine.count("move"), 0U);
    EXPECT_EQ(machine.calls.back(), "end_run");
}

TEST_F(ScanJobTest, ARunFileThatExistsIsNotOverwrittenAndTheMachineGivenBack) {
    folder.write("run.cmmrun", "precious");
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::journal_io);
    EXPECT_EQ(machine.count("home"), 0U);
    EXPECT_EQ(machine.calls.back(), "end_run");
    EXPECT_EQ(std::filesystem::file_size(file), 8U);
}

TEST_F(ScanJobTest, APlanOutsideTheTravelMovesNothing) {
    machine.caps.limit_max_mm.x() = 5.0;
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::plan_invalid);
    EXPECT_EQ(machine.count("begin_run"), 0U);
    EXPECT_FALSE(std::filesystem::exists(file));
}

struct UnknownJobTest : ScanJobTest {
    UnknownJobTest() {
        text = unknown_part_text();
        machine.contact = blade;
    }
    OutlineContact blade{job};
};

TEST_F(UnknownJobTest, FindsThePartAndGoesRoundIt) {
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_TRUE(ran.outcome.result.complete);
    ASSERT_EQ(ran.outcome.result.sections.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        const auto& section = ran.outcome.result.sections[i];
        ASSERT_TRUE(section.has_contour()) << section.why;
        for (const auto& point : section.fit->contour)
            EXPECT_LT(std::abs(distance_to_outline(point.position_mm, blade.outlines.at(i))), 0.02);
    }
    EXPECT_GE(machine.count("touch"), 6U);  // three a section
    EXPECT_TRUE(results_of_run(file, nullptr)->complete);
}

TEST_F(UnknownJobTest, IsResumedInTheMiddleOfASection) {
    machine.cut_after = 60;
    machine.cut_keeps = 1;
    ASSERT_TRUE(run().outcome.error);
    forget();
    machine.cut_after = 0;
    const auto ran = run(true);
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_TRUE(ran.outcome.result.complete);
    ASSERT_EQ(ran.outcome.result.sections.size(), 2U);
    for (const auto& section : ran.outcome.result.sections)
        EXPECT_TRUE(section.has_contour()) << section.why;
    EXPECT_EQ(machine.count("scan"), 2U);
}

TEST_F(UnknownJobTest, NothingThereIsSaidSo) {
    machine.contact = [](const drivers::PathPoint&) { return std::optional<Eigen::Vector3d>(); };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_no_contact);
    EXPECT_TRUE(holds(ran.outcome.error->message, "no part was found")) << ran.outcome.error->text();
    EXPECT_EQ(machine.count("scan"), 0U);
    EXPECT_GT(machine.count("touch"), 3U);
}

}  // namespace
}  // namespace cmm::acquisition
