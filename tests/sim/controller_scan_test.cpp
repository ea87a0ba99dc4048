// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/sim/controller_rig.hpp"

namespace cmm::sim::test {
namespace {

using State = MachineState;

ControllerOptions small_fifo(double speed) {
    ControllerOptions options = bar_options();
    options.machine.fifo_depth = 50;
    options.speed = speed;
    return options;
}

TEST(ControllerScan, EveryPointGivesOneSampleOnTheTrueSurface) {
    Rig rig;
    rig.prepare();
    auto path = arc_path(200, 0.01, 20.0);
    for (PathPoint& point : path)
        point.position *= 1.02;  // a nominal 0.22 mm off
    EXPECT_EQ(rig.scan(1, path).result, ResultCode::ok);
    ASSERT_EQ(rig.samples().size(), 200U);
    for (std::size_t i = 0; i < 200; ++i) {
        const SampleTruth& truth = rig.truth[i];
        const double angle = 0.01 * static_cast<double>(i);
        EXPECT_EQ(truth.index, static_cast<std::int64_t>(i));
        EXPECT_NEAR(truth.centre_mm.x(), circle_mm * std::cos(angle), 1e-8);
        EXPECT_NEAR(truth.centre_mm.y(), circle_mm * std::sin(angle), 1e-8);
        EXPECT_EQ(truth.sample.quality, 0);
        EXPECT_EQ(truth.sample.path, 1);
        EXPECT_NEAR(truth.sample.counts[0], circle_mm * std::cos(angle) * 1e4, 0.51);
    }
    EXPECT_TRUE(rig.controller.path_ended(1));
    EXPECT_EQ(rig.controller.path_passed(), 200U);
    EXPECT_NEAR(rig.controller.position_mm().head<2>().norm(), circle_mm + 1.0, 1e-6) << "retracted";
}

TEST(ControllerScan, SampleTimesKeepSpeedAccelerationAndTick) {
    Rig rig;
    rig.prepare();
    rig.scan(1, arc_path(400, 0.002, 10.0));  // 22 um steps: the tick allows 22 mm/s, the path 10
    const auto samples = rig.samples();
    ASSERT_EQ(samples.size(), 400U);
    const double step = 2 * circle_mm * std::sin(0.001);
    for (std::size_t i = 1; i < samples.size(); ++i) {
        const double dt = static_cast<double>(samples[i].time_us - samples[i - 1].time_us) * 1e-6;
        EXPECT_GE(dt, 1e-3 - 2e-6);
        EXPECT_LE(step / dt, 10.0 * 1.002);
    }
    const double middle = static_cast<double>(samples[250].time_us - samples[150].time_us) * 1e-6;
    EXPECT_NEAR(100 * step / middle, 10.0, 0.01) << "full speed where nothing hinders";
    Rig fast;
    fast.prepare();
    fast.scan(1, arc_path(400, 0.001, 100.0));
    const auto dense = fast.samples();
    EXPECT_NEAR(static_cast<double>(dense[300].time_us - dense[100].time_us), 200 * 1000.0, 300.0)
        << "one sample per tick, not more";
}

TEST(ControllerScan, CountsDependOnPathAndSeedAlone) {
    ControllerOptions options = bar_options();
    options.part.noise_mm = 0.002;
    options.part.bad_points_share = 0.05;
    const auto path = arc_path(500, 0.01, 20.0);
    Rig whole(options);
    whole.prepare();
    whole.scan(4, path);
    options.speed = 0.0;
    Rig pieces(options);
    pieces.prepare();
    pieces.send(opcode::path_begin, {4});
    const std::span<const PathPoint> all(path);
    pieces.controller.append_path(4, 0, all.first(3));
    pieces.send(opcode::scan, {4, 10000, 10000, 10000});
    for (std::uint32_t first = 3; first < 500; first += 7) {
        pieces.run_ms(3);
        pieces.controller.append_path(4, first, all.subspan(first, std::min<std::size_t>(7, 500 - first)));
    }
    EXPECT_EQ(pieces.finish().result, ResultCode::ok);
    ASSERT_EQ(whole.samples().size(), 500U);
    ASSERT_EQ(pieces.samples().size(), 500U);
    for (std::size_t i = 0; i < 500; ++i)
        EXPECT_EQ(whole.samples()[i].counts, pieces.samples()[i].counts) << i;
    options.seed = 2;
    Rig other(options);
    other.prepare();
    other.scan(4, path);
    int equal = 0;
    for (std::size_t i = 0; i < 500; ++i)
        equal += whole.samples()[i].counts == other.samples()[i].counts ? 1 : 0;
    EXPECT_LT(equal, 50) << "another seed is another run";
}

TEST(ControllerScan, StarvesInContactAndGoesOn) {
    Rig rig;
    rig.prepare();
    const auto path = arc_path(40, 0.02, 20.0);
    const std::span<const PathPoint> all(path);
    rig.send(opcode::path_begin, {1});
    rig.controller.append_path(1, 0, all.first(20));
    rig.send(opcode::scan, {1, 10000, 10000, 10000});
    rig.run_ms(3000);
    EXPECT_EQ(rig.controller.state(), State::starved);
    EXPECT_EQ(rig.controller.path_passed(), 20U);
    EXPECT_EQ(rig.controller.flags() & (4 | 8), 4) << "in contact, not in motion";
    EXPECT_FALSE(rig.controller.path_ended(1));
    EXPECT_EQ(rig.controller.command_status().state, CommandState::running);
    rig.controller.append_path(1, 0, all.first(10));
    rig.run_ms(10);
    EXPECT_EQ(rig.controller.state(), State::starved) << "a repeated window is no new path";
    rig.controller.append_path(1, 20, all.subspan(20));
    EXPECT_EQ(rig.finish().result, ResultCode::ok);
    EXPECT_EQ(rig.samples().size(), 40U);
}

TEST(ControllerScan, AppendingInTimeKeepsTheSpeed) {
    Rig rig;
    rig.prepare();
    const auto path = arc_path(300, 0.01, 20.0);
    const std::span<const PathPoint> all(path);
    rig.send(opcode::path_begin, {1});
    rig.controller.append_path(1, 0, all.first(50));
    rig.send(opcode::scan, {1, 10000, 10000, 10000});
    std::uint32_t sent = 50;
    while (rig.controller.command_status().state == CommandState::running) {
        rig.run_ms(1);
        ASSERT_NE(rig.controller.state(), State::starved);
        if (sent < 300 && sent - rig.controller.path_passed() < 40) {
            rig.controller.append_path(1, sent, all.subspan(sent, 10));
            sent += 10;
        }
    }
    const auto samples = rig.samples();
    ASSERT_EQ(samples.size(), 300U);
    const double took_s = static_cast<double>(samples[299].time_us - samples[0].time_us) * 1e-6;
    EXPECT_NEAR(took_s, 299 * 0.11 / 20.0, 0.03);
}

TEST(ControllerScan, LossOfContactFailsAfterTwoMillimetres) {
    Rig rig;
    rig.prepare();
    auto path = arc_path(100, 0.02, 20.0);
    for (std::size_t i = 50; i < 100; ++i)
        path[i].position += 3.0 * path[i].normal;  // out of the 1 mm search
    expect_failed(rig.scan(1, path), ResultCode::no_contact);
    EXPECT_EQ(rig.controller.state(), State::idle);
    EXPECT_TRUE(rig.controller.path_ended(1));
    const auto samples = rig.samples();
    ASSERT_GT(samples.size(), 50U);
    EXPECT_EQ(samples[49].quality, 0);
    EXPECT_EQ(samples[50].quality, quality::no_contact);
    EXPECT_LE(samples.size(), 59U);
}

TEST(ControllerScan, AShortGapIsFlaggedAndCrossed) {
    Rig rig;
    rig.prepare();
    auto path = arc_path(100, 0.01, 20.0);
    for (std::size_t i = 50; i < 54; ++i)
        path[i].position += 1.5 * path[i].normal;
    EXPECT_EQ(rig.scan(1, path).result, ResultCode::ok);
    const auto samples = rig.samples();
    ASSERT_EQ(samples.size(), 100U);
    for (std::size_t i = 0; i < 100; ++i)
        EXPECT_EQ(samples[i].quality != 0, i >= 50 && i < 54) << i;
}

TEST(ControllerScan, NothingUnderTheFirstPoint) {
    Rig rig;
    rig.prepare();
    auto path = arc_path(10, 0.01, 20.0);
    for (PathPoint& point : path)
        point.position += 5.0 * point.normal;
    expect_failed(rig.scan(1, path), ResultCode::no_contact);
    EXPECT_TRUE(rig.samples().empty());
    EXPECT_TRUE(rig.controller.path_ended(1));
}

TEST(ControllerScan, TravelToThePathMayCollide) {
    Rig rig;
    rig.prepare();
    expect_failed(rig.scan(1, arc_path(10, 0.01, 20.0, 0.0, std::numbers::pi)), ResultCode::collision);
    EXPECT_EQ(rig.controller.state(), State::fault);
}

TEST(ControllerScan, PathsThatCannotBeScanned) {
    Rig rig;
    rig.prepare();
    expect_failed(rig.send(opcode::scan, {1, 10000, 10000, 10000}), ResultCode::path_invalid);
    rig.send(opcode::path_begin, {1});
    expect_failed(rig.send(opcode::scan, {1, 10000, 10000, 10000}), ResultCode::path_invalid);
    const auto good = arc_path(5, 0.01, 20.0);
    EXPECT_EQ(rig.controller.append_path(2, 0, good), ScanPath::Append::invalid) << "another path's window";
    rig.upload(1, good);
    expect_failed(rig.send(opcode::scan, {2, 10000, 10000, 10000}), ResultCode::path_invalid);
    expect_failed(rig.send(opcode::scan, {1, -1, 10000, 10000}), ResultCode::bad_argument);
    expect_failed(rig.send(opcode::scan, {1, 10000, 0, 10000}), ResultCode::bad_argument);
    expect_failed(rig.send(opcode::scan, {1, 10000000, 10000, 10000}), ResultCode::travel_limit);
    EXPECT_EQ(rig.finish(opcode::scan, {1, 10000, 10000, 10000}).result, ResultCode::ok);
    expect_failed(rig.send(opcode::scan, {1, 10000, 10000, 10000}), ResultCode::path_invalid);
    auto bent = good;
    bent[2].normal *= 1.1;
    expect_failed(rig.scan(2, bent), ResultCode::path_invalid);
    auto standing = good;
    standing[4].speed_mm_s = 0.0;
    expect_failed(rig.scan(3, standing), ResultCode::path_invalid);
    auto outside = good;
    outside[3].position.z() = -101.0;
    expect_failed(rig.scan(4, outside), ResultCode::travel_limit);
    EXPECT_EQ(rig.controller.state(), State::idle);
}

TEST(ControllerScan, ABadWindowEndsTheRunningScan) {
    Rig rig;
    rig.prepare();
    auto path = arc_path(40, 0.02, 20.0);
    path[30].speed_mm_s = 0.0;
    rig.send(opcode::path_begin, {1});
    rig.controller.append_path(1, 0, std::span<const PathPoint>(path).first(20));
    rig.send(opcode::scan, {1, 10000, 10000, 10000});
    rig.run_ms(50);
    rig.controller.append_path(1, 20, std::span<const PathPoint>(path).subspan(20));
    expect_failed(rig.finish(), ResultCode::path_invalid);
    EXPECT_EQ(rig.controller.state(), State::idle);
    EXPECT_TRUE(rig.controller.path_ended(1));
}

TEST(ControllerScan, AFullFifoEndsThePathInTimedRuns) {
    Rig rig(small_fifo(1.0));
    rig.prepare();
    expect_failed(rig.scan(1, arc_path(100, 0.01, 20.0)), ResultCode::overflow);
    EXPECT_EQ(rig.controller.state(), State::fault);
    EXPECT_TRUE(rig.controller.overflowed());
    EXPECT_EQ(rig.samples().size(), 50U);
    EXPECT_EQ(rig.controller.fifo().newest(), 50U) << "what was lost got no number";
    EXPECT_TRUE(rig.controller.acknowledge(50));
    EXPECT_EQ(rig.send(opcode::clear_fault).state, CommandState::done);
    EXPECT_FALSE(rig.controller.overflowed());
}

TEST(ControllerScan, AFullFifoHoldsTheClockAsFastAsItGoes) {
    Rig rig(small_fifo(0.0));
    rig.prepare();
    rig.begin_scan(1, arc_path(200, 0.01, 20.0));
    rig.run_ms(100);
    EXPECT_EQ(rig.controller.fifo().level(), 50U);
    const std::int64_t stands = rig.controller.time_us();
    rig.run_ms(300);
    EXPECT_EQ(rig.controller.time_us(), stands);
    std::uint32_t acknowledged = 0;
    while (rig.controller.command_status().state == CommandState::running && acknowledged < 200) {
        rig.controller.acknowledge(acknowledged += 10);
        rig.run_ms(1);
    }
    EXPECT_EQ(rig.finish().result, ResultCode::ok);
    EXPECT_EQ(rig.truth.size(), 200U);
    EXPECT_FALSE(rig.controller.overflowed());
}

TEST(ControllerScan, SilenceStopsAlsoTheFastestRun) {
    Rig rig(small_fifo(0.0));
    rig.prepare();
    rig.begin_scan(1, arc_path(200, 0.01, 20.0));
    rig.run_ms(10);
    rig.clock.advance(std::chrono::milliseconds(501));
    rig.controller.step();
    EXPECT_EQ(rig.controller.state(), State::stopped);
    EXPECT_EQ(rig.controller.fault(), ResultCode::watchdog);
    EXPECT_EQ(rig.controller.owner(), 0U);
    EXPECT_EQ(rig.samples().size(), 50U) << "the samples stay";
}

TEST(ControllerScan, StopOnThePathIsQuickAndRecordsNoMore) {
    Rig rig;
    rig.prepare();
    rig.begin_scan(1, arc_path(400, 0.005, 20.0));
    while (rig.controller.path_passed() < 100)
        rig.run_ms(1);
    const std::uint32_t newest = rig.controller.fifo().newest();
    rig.controller.stop(StopKind::controlled);
    rig.run_ms(15);  // 20 / 1500 s
    EXPECT_EQ(rig.controller.state(), State::stopped);
    expect_failed(rig.controller.command_status(), ResultCode::stopped);
    EXPECT_EQ(rig.controller.fifo().newest(), newest);
    EXPECT_TRUE(rig.controller.path_ended(1));
    EXPECT_NEAR(rig.controller.position_mm().head<2>().norm(), circle_mm, 1e-3) << "stays on the part";
}

TEST(ControllerScan, PositionFollowsThePath) {
    Rig rig;
    rig.prepare();
    rig.begin_scan(1, arc_path(400, 0.01, 20.0));
    while (rig.controller.path_passed() < 10)
        rig.run_ms(1);
    Eigen::Vector3d last = rig.controller.position_mm();
    for (int i = 0; i < 200; ++i) {
        rig.run_ms(1);
        const Eigen::Vector3d now = rig.controller.position_mm();
        EXPECT_LE((now - last).norm(), 20.0 * 1e-3 * 1.01);
        EXPECT_NEAR(now.head<2>().norm(), circle_mm, 2e-4) << "between the points on the chord";
        last = now;
    }
}

TEST(ControllerScan, APointAtTheSamePlaceTakesATick) {
    Rig rig;
    rig.prepare();
    auto path = arc_path(20, 0.01, 20.0);
    path[10] = path[9];
    EXPECT_EQ(rig.scan(1, path).result, ResultCode::ok);
    const auto samples = rig.samples();
    ASSERT_EQ(samples.size(), 20U);
    EXPECT_NEAR(static_cast<double>(samples[10].time_us - samples[9].time_us), 1000.0, 1.0);
}

TEST(ControllerScan, PointsWithoutTheFlagAreNotRecorded) {
    Rig rig;
    rig.prepare();
    auto path = arc_path(40, 0.01, 20.0);
    for (std::size_t i = 0; i < 40; i += 2)
        path[i].record = false;
    EXPECT_EQ(rig.scan(1, path).result, ResultCode::ok);
    EXPECT_EQ(rig.samples().size(), 20U);
    EXPECT_EQ(rig.controller.path_passed(), 40U);
    EXPECT_EQ(rig.truth[3].index, 7);
}

}  // namespace
}  // namespace cmm::sim::test
