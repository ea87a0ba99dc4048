// SPDX-License-Identifier: Apache-2.0
// Several requests in flight over Modbus TCP: replies find their requests, nothing is lost or doubled, and a stop does
// not wait for what was sent before it.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

#include "machine_fixtures.hpp"
#include "scripted_controller.hpp"
#include "tests/support/distant_network.hpp"

namespace cmm::drivers {
namespace {

using namespace std::chrono_literals;
using cmm::test::DistantNetwork;
using test::Fault;
using test::RecordingSink;
using test::Request;
using test::scan_ring;
using test::ScriptedController;
using Clock = std::chrono::steady_clock;

struct WithController {
    ScriptedController controller_;
};

class InFlightMachine : protected WithController, public test::PlayedMachineTest {
  protected:
    InFlightMachine() : PlayedMachineTest(controller_.url() + "?in_flight=32") {}

    void expect_whole_scan(std::size_t points) {
        RecordingSink sink;
        const auto scanned = scan(points, sink);
        ASSERT_TRUE(scanned) << scanned.error().text();
        EXPECT_EQ(sink.delivered(), points);
        EXPECT_TRUE(sink.out_of_order.empty());
        EXPECT_EQ(controller_.acknowledged(), points);
        EXPECT_EQ(controller_.executed(7), 1);
        const auto path = test::circle_path(20.0, 5.0, points, 10.0);
        for (std::size_t k = 0; k < path.size(); ++k)
            ASSERT_LT((core::centre_mm(sink.kept[k], 1e-4) - path[k].centre_mm).norm(), 1e-4) << k;
    }
};

TEST_F(InFlightMachine, RepliesInReverseOrderFindTheirRequests) {
    begin();
    controller_.on_request(
        [](const Request& request) { return request.function == 6 ? Fault::none : Fault::last_first; });
    expect_whole_scan(400);
    const LinkStats stats = machine().link_stats();
    EXPECT_EQ(stats.errors(), 0U);
    EXPECT_EQ(stats.stale, 0U);
    EXPECT_EQ(stats.half_answered, 0U);
}

TEST_F(InFlightMachine, ABatchHalfAnsweredTwiceIsTheLast) {
    begin();
    controller_.on_request([](const Request&) { return Fault::alone; });
    expect_whole_scan(400);
    const LinkStats stats = machine().link_stats();
    EXPECT_EQ(stats.half_answered, 2U);
    EXPECT_NE(stats.note.find("one at a time"), std::string::npos) << stats.note;
    EXPECT_EQ(controller_.connections(), 1);
}

TEST_F(InFlightMachine, ABatchHalfAnsweredOnceIsForgiven) {
    begin();
    std::atomic<int> dropped{0};
    controller_.on_request(
        [&](const Request& request) { return request.function == 23 && dropped++ == 0 ? Fault::alone : Fault::none; });
    expect_whole_scan(400);
    EXPECT_LE(machine().link_stats().half_answered, 1U);
    EXPECT_TRUE(machine().link_stats().note.empty());
}

TEST_F(InFlightMachine, AControllerThatClosesOnABatchIsServedOneByOne) {
    begin();
    std::atomic<std::size_t> windows{0};
    // The second window in a row was sent before the first was answered: that is what such a controller dislikes.
    controller_.on_request([&](const Request& request) {
        const bool window = request.function == 16 && request.address == 256;
        windows = window ? windows + 1 : 0;
        return windows == 2 && machine().link_stats().note.empty() ? Fault::closed : Fault::none;
    });
    expect_whole_scan(400);
    EXPECT_FALSE(machine().link_stats().note.empty());
    EXPECT_LE(controller_.connections(), 4);
}

TEST_F(InFlightMachine, AStopGoesOutWhileABatchIsUnanswered) {
    settings_.response_timeout_ms = 50'000.0;
    controller_.set_register(25, 60'000);  // a patient watchdog, so that the batch is waited for
    link_to(settings_);
    begin();
    std::atomic<bool> mute{false};
    std::atomic<int> muted{0};
    controller_.on_request([&](const Request& request) {
        if (!mute || request.function == 6) return Fault::none;
        ++muted;
        return Fault::silent;
    });
    RecordingSink sink;
    sink.on_delivery = [&] { mute = mute || sink.delivered() >= 60; };
    const auto points = test::circle_path(20.0, 5.0, 100'000, 10.0);
    PointList source(points);
    const auto scanning = rig_->start(machine().scan(ScanPath{}, source, sink));
    ASSERT_TRUE(rig_->wait([&] { return muted.load() >= 2; }));
    const auto asked = Clock::now();
    machine().stop(StopKind::controlled);
    ASSERT_TRUE(rig_->wait([&] { return controller_.stop_value() == 1; }));
    EXPECT_FALSE(scanning->done()) << "what was sent before is still unanswered";
    const double ms = std::chrono::duration<double, std::milli>(controller_.stop_arrived() - asked).count();
    std::printf("stop at the controller %.3f ms after the request, %d requests unanswered\n", ms, muted.load());
    mute = false;
    controller_.restart();  // ends the wait for replies that never come
    ASSERT_TRUE(rig_->wait([&] { return scanning->done(); }));
    EXPECT_FALSE(*scanning->result);
}

TEST_F(InFlightMachine, ASlowControllerGetsNoQueueThatAStopWouldWaitBehind) {
    settings_.response_timeout_ms = 500.0;
    link_to(settings_);
    begin();
    std::atomic<int> served{0}, served_after{0};
    std::atomic<bool> stopped{false};
    controller_.on_request([&](const Request& request) {
        if (request.function == 6) stopped = true;
        std::this_thread::sleep_for(5ms);  // the controller's own time for a request
        if (served < 150 && ++served == 150) machine().stop(StopKind::controlled);
        if (served == 150 && !stopped) ++served_after;
        return Fault::none;
    });
    RecordingSink sink;
    const auto scanned = scan(100'000, sink);
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, core::ErrorCode::cancelled) << scanned.error().text();
    EXPECT_LE(served_after, 8) << "requests before the stop; 4 of 5 ms are what it may wait for";
    EXPECT_EQ(sink.delivered(), controller_.newest());
}

/// A ring of a simulated part, scanned over a distant link.
double scan_time_s(std::size_t points, const std::string& options, std::vector<core::Sample>& samples) {
    const test::Workshop workshop;
    const auto simulator = workshop.start(0.0);
    const DistantNetwork network(simulator->port(), 10ms);
    const auto begun = Clock::now();
    samples = scan_ring(network.modbus_url(options), points);
    return std::chrono::duration<double>(Clock::now() - begun).count();
}

TEST(DistantLink, ManyInFlightBringTheSameSamplesInAFractionOfTheTime) {
    std::vector<core::Sample> one_by_one, many;
    const double slow_s = scan_time_s(600, "unit=1&in_flight=1", one_by_one);
    const double fast_s = scan_time_s(600, "unit=1", many);
    std::printf("600 points, 20 ms round trip: %.2f s one at a time, %.2f s with 32 in flight\n", slow_s, fast_s);
    EXPECT_LT(fast_s, slow_s / 2.0);
    ASSERT_EQ(many.size(), one_by_one.size());
    for (std::size_t k = 0; k < many.size(); ++k)
        ASSERT_EQ(many[k].counts, one_by_one[k].counts) << k;
}

}  // namespace
}  // namespace cmm::drivers
