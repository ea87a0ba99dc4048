// SPDX-License-Identifier: Apache-2.0
// The Modbus driver on a bad link: nothing is executed twice, no sample lost or doubled, a stop gets through.
#include <gtest/gtest.h>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <thread>
#include <vector>

#include "machine_fixtures.hpp"
#include "scripted_controller.hpp"

namespace cmm::drivers {
namespace {

using core::ErrorCode;
using test::Fault;
using test::MachineRig;
using test::RecordingSink;
using test::Request;
using test::ScriptedController;
using Clock = std::chrono::steady_clock;

// The controller is there before the machine that connects to it.
struct WithController {
    ScriptedController controller_;
};

class ModbusFault : protected WithController, public test::PlayedMachineTest {
  protected:
    ModbusFault() : PlayedMachineTest(controller_.url()) {}
};

TEST_F(ModbusFault, ACommandIsExecutedOnceThoughItsReplyWasLost) {
    begin();
    for (const Fault fault :
         {Fault::lost_reply, Fault::closed_mid, Fault::truncated, Fault::late_reply, Fault::wrong_id, Fault::garbage}) {
        const int before = controller_.executed(3);
        std::atomic<bool> spoilt{false};
        controller_.on_request([&](const Request& request) {
            const bool command = request.function == 16 && request.address == 128;
            return command && !spoilt.exchange(true) ? fault : Fault::none;
        });
        const auto homed = rig_->run(machine().home());
        EXPECT_TRUE(homed) << homed.error().text();
        EXPECT_TRUE(spoilt);
        EXPECT_EQ(controller_.executed(3), before + 1) << "fault " << static_cast<int>(fault);
    }
    EXPECT_GT(machine().link_stats().retries, 0U);
    EXPECT_GT(machine().link_stats().stale, 0U) << "the late reply must be seen and dropped";
}

struct FaultInFlight {
    Fault fault;
    int in_flight;
};

/// Every fault at every seventh request of a scan, one request at a time and many.
class ModbusScanFault : public ModbusFault, public testing::WithParamInterface<FaultInFlight> {};

TEST_P(ModbusScanFault, NoSampleIsLostOrDoubled) {
    settings_.endpoint.options["in_flight"] = std::to_string(GetParam().in_flight);
    link_to(settings_);
    begin();
    controller_.on_request([](const Request& request) {
        return request.number % 7 == 0 && request.function != 6 ? GetParam().fault : Fault::none;
    });
    RecordingSink sink;
    const auto scanned = scan(300, sink);
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_EQ(sink.delivered(), 300U);
    EXPECT_TRUE(sink.out_of_order.empty());
    EXPECT_EQ(controller_.newest(), 300U);
    EXPECT_EQ(controller_.acknowledged(), 300U);
    EXPECT_EQ(controller_.executed(7), 1);
    EXPECT_EQ(controller_.executed(10), 1);
    const LinkStats stats = machine().link_stats();
    // Among several in flight a late reply need not come too late.
    if (GetParam().fault == Fault::late_reply && GetParam().in_flight > 1) return;
    EXPECT_GT(stats.retries, 0U);
    EXPECT_GT(stats.errors(), 0U);
}

std::string name_of(Fault fault) {
    switch (fault) {
        case Fault::silent:
            return "Silent";
        case Fault::lost_reply:
            return "LostReply";
        case Fault::late_reply:
            return "LateReply";
        case Fault::wrong_id:
            return "WrongId";
        case Fault::truncated:
            return "Truncated";
        case Fault::closed_mid:
            return "ClosedMid";
        case Fault::closed:
            return "Closed";
        case Fault::bad_crc:
            return "BadCrc";
        case Fault::garbage:
            return "Garbage";
        default:
            return "Other";
    }
}

std::vector<FaultInFlight> faults_in_flight() {
    std::vector<FaultInFlight> all;
    for (const int in_flight : {1, 32}) {
        for (const Fault fault : {Fault::silent, Fault::lost_reply, Fault::late_reply, Fault::wrong_id,
                                  Fault::truncated, Fault::closed_mid, Fault::closed, Fault::garbage, Fault::bad_crc})
            all.push_back({fault, in_flight});
    }
    return all;
}

INSTANTIATE_TEST_SUITE_P(Faults, ModbusScanFault, testing::ValuesIn(faults_in_flight()), [](const auto& fault) {
    return name_of(fault.param.fault) + std::to_string(fault.param.in_flight);
});

TEST_F(ModbusFault, ABlockWithABadCrcIsAskedForAgain) {
    begin();
    std::atomic<int> spoilt{0};
    controller_.on_request([&](const Request& request) {
        if (request.function != 23 || request.number % 5 != 0) return Fault::none;
        ++spoilt;
        return Fault::bad_crc;
    });
    RecordingSink sink;
    const auto scanned = scan(200, sink);
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_GT(spoilt, 0);
    EXPECT_EQ(machine().link_stats().invalid, static_cast<std::uint64_t>(spoilt));
    EXPECT_EQ(sink.delivered(), 200U);
    EXPECT_TRUE(sink.out_of_order.empty());
}

TEST_F(ModbusFault, ABlockSentTwiceIsTakenOnce) {
    begin();
    controller_.on_request([](const Request& request) {
        return request.function == 23 && request.number % 3 == 0 ? Fault::old_block : Fault::none;
    });
    RecordingSink sink;
    const auto scanned = scan(200, sink);
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_EQ(sink.delivered(), 200U);
    EXPECT_TRUE(sink.out_of_order.empty());
    EXPECT_GT(machine().link_stats().duplicate_samples, 0U);
}

TEST_F(ModbusFault, AWindowRefusedAsBusyIsSentAgain) {
    begin();
    std::atomic<int> refusals{0};
    controller_.on_request([&](const Request& request) {
        if (request.function != 16 || request.address != 256 || request.number % 2 != 0) return Fault::none;
        ++refusals;
        return Fault::busy;
    });
    RecordingSink sink;
    const auto scanned = scan(300, sink);
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_GT(refusals, 0);
    EXPECT_EQ(sink.delivered(), 300U);
    EXPECT_EQ(scanned->points_passed, 300U);
}

TEST_F(ModbusFault, TheFirstQuestionMayGetLost) {
    controller_.on_request(
        [](const Request& request) { return request.number == 1 ? Fault::lost_reply : Fault::none; });
    begin();
}

TEST_F(ModbusFault, ACommandRefusedAsBusyIsGivenAgain) {
    begin();
    std::atomic<int> refusals{0};
    controller_.on_request([&](const Request& request) {
        const bool command = request.function == 16 && request.address == 128;
        return command && ++refusals <= 2 ? Fault::busy : Fault::none;
    });
    const auto homed = rig_->run(machine().home());
    EXPECT_TRUE(homed) << homed.error().text();
    EXPECT_EQ(refusals, 3);
    EXPECT_EQ(controller_.executed(3), 1);
}

TEST_F(ModbusFault, AnExchangeThatIsRefusedNowAndThenIsAskedAgain) {
    begin();
    controller_.on_request([](const Request& request) {
        const bool question = request.function == 23 || request.function == 3;
        return question && request.number % 5 == 0 ? Fault::illegal_value : Fault::none;
    });
    RecordingSink sink;
    const auto scanned = scan(200, sink);
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_EQ(sink.delivered(), 200U);
    EXPECT_TRUE(sink.out_of_order.empty());
}

TEST_F(ModbusFault, AStatusFromBeforeTheLastCommandGivesNoNumberThatIsTaken) {
    begin();
    ASSERT_TRUE(rig_->run(machine().home()));
    std::atomic<bool> spoilt{false};
    controller_.on_request([&](const Request& request) {
        const bool status = request.function == 3 && request.address == 64;
        return status && !spoilt.exchange(true) ? Fault::old_status : Fault::none;
    });
    ASSERT_TRUE(rig_->run(machine().move({1.0, 2.0, 3.0}, 10.0)));
    EXPECT_EQ(controller_.executed(5), 1);
}

TEST_F(ModbusFault, AWindowRefusedForGoodStopsTheMachine) {
    begin();
    controller_.on_request([&](const Request& request) {
        const bool late_window = request.function == 16 && request.address == 256 && controller_.executed(7) > 0;
        return late_window ? Fault::illegal_value : Fault::none;
    });
    RecordingSink sink;
    const auto scanned = scan(300, sink);
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, ErrorCode::protocol_invalid);
    EXPECT_EQ(scanned.error().motion, core::Motion::stopped);
    EXPECT_EQ(controller_.stop_value(), 1U);
}

TEST_F(ModbusFault, ARestartedControllerIsNoticed) {
    begin();
    RecordingSink sink;
    sink.on_delivery = [&] {
        if (sink.delivered() >= 50 && controller_.register_at(44) == 77) controller_.restart();
    };
    const auto scanned = scan(2000, sink);
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, ErrorCode::machine_fault);
    EXPECT_NE(scanned.error().text().find("boot id 77, now 78"), std::string::npos) << scanned.error().text();
    EXPECT_TRUE(sink.out_of_order.empty());
}

TEST_F(ModbusFault, ALinkThatStaysDownEndsTheScan) {
    settings_.reconnect_ms = 300.0;
    link_to(settings_);
    begin();
    std::atomic<bool> dead{false};
    controller_.on_request([&](const Request&) { return dead ? Fault::closed : Fault::none; });
    RecordingSink sink;
    sink.on_delivery = [&] { dead = dead || sink.delivered() >= 50; };
    const auto scanned = scan(2000, sink);
    ASSERT_FALSE(scanned);
    EXPECT_EQ(core::exit_code(scanned.error().code), 5) << scanned.error().text();
    EXPECT_EQ(scanned.error().motion, core::Motion::may_be_moving) << "the watchdog time is not over";
}

TEST_F(ModbusFault, NobodyListensIsNotWaitedFor) {
    controller_.close_listener();
    const auto found = rig_->run(machine().connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::transport_connect);
    EXPECT_NE(found.error().text().find("127.0.0.1:"), std::string::npos) << found.error().text();
    EXPECT_EQ(found.error().text().find("no answer within"), std::string::npos) << found.error().text();
}

TEST_F(ModbusFault, AnUnknownHostIsNamed) {
    MachineRig rig(test::settings_for("modbus+tcp://no-such-host.invalid:502"));
    const auto found = rig.run(rig.machine->connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::transport_connect);
    EXPECT_NE(found.error().text().find("no-such-host.invalid"), std::string::npos);
}

/// A listener whose queue is full drops further connection requests: from outside, a host that does not answer.
class FullListener {
  public:
    FullListener() : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        name_.sin_family = AF_INET;
        name_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof name_;
        EXPECT_EQ(::bind(fd_, address(), size), 0);
        EXPECT_EQ(::listen(fd_, 0), 0);
        ::getsockname(fd_, address(), &size);
        for (int& filler : fillers_) {
            filler = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
            ::connect(filler, address(), size);
        }
    }
    ~FullListener() {
        for (const int filler : fillers_)
            ::close(filler);
        ::close(fd_);
    }
    FullListener(const FullListener&) = delete;
    FullListener& operator=(const FullListener&) = delete;
    std::string url() const { return "modbus+tcp://127.0.0.1:" + std::to_string(ntohs(name_.sin_port)); }

  private:
    sockaddr* address() { return static_cast<sockaddr*>(static_cast<void*>(&name_)); }
    int fd_;
    sockaddr_in name_{};
    std::array<int, 4> fillers_{};
};

TEST_F(ModbusFault, AnUnreachableHostIsGivenUpAfterTheConnectTimeout) {
    const FullListener listener;
    LinkSettings settings = test::settings_for(listener.url());
    settings.connect_timeout_ms = 200.0;
    MachineRig rig(settings);
    const auto found = rig.run(rig.machine->connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::transport_connect);
    EXPECT_NE(found.error().text().find("no answer within 200 ms"), std::string::npos) << found.error().text();
}

TEST_F(ModbusFault, AListenerThatSaysNothingIsNoController) {
    controller_.on_request([](const Request&) { return Fault::silent; });
    const auto found = rig_->run(machine().connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::transport_timeout);
    EXPECT_NE(found.error().text().find("does not answer"), std::string::npos) << found.error().text();
}

TEST_F(ModbusFault, AStopOvertakesATransactionInFlight) {
    settings_.response_timeout_ms = 50'000.0;  // longer than the test waits for the stop
    controller_.set_register(25, 60'000);      // a patient watchdog, so that the lost reply is waited for
    link_to(settings_);
    begin();
    controller_.motions_take(1'000'000);
    std::atomic<bool> mute{false}, muted{false};
    controller_.on_request([&](const Request& request) {
        if (!mute || request.function == 6) return Fault::none;
        muted = true;
        return Fault::silent;
    });
    const auto homing = rig_->start(machine().home());
    ASSERT_TRUE(rig_->wait([&] { return controller_.executed(3) == 1; }));
    mute = true;
    ASSERT_TRUE(rig_->wait([&] { return muted.load(); }));
    const auto asked = Clock::now();
    std::thread other([&] {
        machine().stop(StopKind::controlled);
        machine().stop(StopKind::controlled);
    });
    other.join();
    ASSERT_TRUE(rig_->wait([&] { return controller_.stop_value() == 1; }));
    EXPECT_FALSE(homing->done()) << "the transaction before it is still unanswered";
    const double ms = std::chrono::duration<double, std::milli>(controller_.stop_arrived() - asked).count();
    std::printf("stop at the controller %.3f ms after the request, with a transaction in flight\n", ms);
    RecordProperty("stop_ms", std::to_string(ms));
    EXPECT_TRUE(rig_->wait([&] { return machine().link_stats().stops >= 1; }));
    mute = false;
    controller_.restart();  // ends the wait for the reply that never comes
    ASSERT_TRUE(rig_->wait([&] { return homing->done(); }));
    EXPECT_FALSE(*homing->result);
}

TEST_F(ModbusFault, AStopIsBroughtOverAFreshLinkWhenTheOldOneIsDead) {
    begin();
    std::atomic<bool> closed{false};
    controller_.on_request([&](const Request& request) {
        return request.function == 6 && !closed.exchange(true) ? Fault::closed : Fault::none;
    });
    machine().stop(StopKind::emergency);
    ASSERT_TRUE(rig_->wait([&] { return controller_.stop_value() == 2; }));
    EXPECT_EQ(controller_.connections(), 2);
}

TEST_F(ModbusFault, StopInEveryStateDoesNoHarm) {
    machine().stop(StopKind::controlled);  // not connected yet
    machine().stop(StopKind::emergency);
    link_to(settings_);
    begin();
    machine().stop(StopKind::controlled);
    machine().stop(StopKind::controlled);
    ASSERT_TRUE(rig_->wait([&] { return controller_.stop_value() == 1; }));
    EXPECT_TRUE(rig_->run(machine().clear_fault()));
    EXPECT_TRUE(rig_->run(machine().home()));
}

TEST_F(ModbusFault, AStopThatGetsLostAgainAndAgainStopsTheScanAllTheSame) {
    begin();
    std::atomic<int> stops{0};
    controller_.on_request(
        [&](const Request& request) { return request.function == 6 && ++stops <= 5 ? Fault::closed : Fault::none; });
    RecordingSink sink;
    sink.on_delivery = [&] {
        if (sink.delivered() >= 60 && stops == 0) machine().stop(StopKind::controlled);
    };
    const auto scanned = scan(200'000, sink);
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, ErrorCode::cancelled);
    EXPECT_GT(stops, 5);
}

TEST_F(ModbusFault, AStopDuringAScanIsReportedAfterItsSamples) {
    begin();
    RecordingSink sink;
    sink.on_delivery = [&] {
        if (sink.delivered() >= 60) machine().stop(StopKind::controlled);
    };
    const auto scanned = scan(5000, sink);
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, ErrorCode::cancelled);
    EXPECT_EQ(scanned.error().motion, core::Motion::stopped);
    EXPECT_EQ(sink.delivered(), controller_.newest());
    EXPECT_LT(sink.delivered(), 5000U);
}

}  // namespace
}  // namespace cmm::drivers
