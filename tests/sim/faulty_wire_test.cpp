// SPDX-License-Identifier: Apache-2.0
// What each fault of the wire does to the bytes, with a protocol behind it that answers every four bytes.
#include "sim/faulty_wire.hpp"

#include <gtest/gtest.h>

#include "tests/sim/controller_rig.hpp"

namespace cmm::sim::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Answers four bytes with eight: the first one eight times.
class EightForFour final : public WireProtocol {
  public:
    Progress answer(std::span<const std::uint8_t> in, core::Duration, Bytes& out) override {
        if (in.size() < 4) return {};
        out.insert(out.end(), 8, in[0]);
        return {4, true};
    }
};

class FaultyWireTest : public testing::Test {
  protected:
    void plan(FaultKind kind, double at_request, double amount = 0.0, double for_s = 0.0, int times = 1) {
        FaultPlan plan;
        plan.faults.push_back(
            {kind, {FaultTime::Count::requests, at_request, at_request}, false, amount, for_s, times});
        play_ = std::make_unique<FaultPlay>(plan, 1, rig_.controller, rig_.clock,
                                            [this](const std::string& line) { told_.push_back(line); });
    }
    void wire(FaultyWire::Kind kind) {
        wire_ = std::make_unique<FaultyWire>(kind, std::make_unique<EightForFour>(), *play_);
    }
    /// Four bytes `mark` come; returns what is sent at once.
    Bytes ask(std::uint8_t mark) {
        Bytes fresh(4, mark);
        wire_->arrived(fresh);
        in_.insert(in_.end(), fresh.begin(), fresh.end());
        Bytes out;
        progress_ = wire_->answer(in_, {}, out);
        in_.erase(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(progress_.used));
        return out;
    }
    Bytes later(int ms) {
        rig_.clock.advance(std::chrono::milliseconds(ms));
        play_->step();
        Bytes out;
        progress_ = wire_->idle(out);
        return out;
    }
    static Bytes reply(std::uint8_t mark) { return Bytes(8, mark); }
    static Bytes together(Bytes first, const Bytes& second) {
        first.insert(first.end(), second.begin(), second.end());
        return first;
    }

    Rig rig_;
    std::vector<std::string> told_;
    std::unique_ptr<FaultPlay> play_;
    std::unique_ptr<FaultyWire> wire_;
    Bytes in_;
    WireProtocol::Progress progress_;
};

TEST_F(FaultyWireTest, NothingHappensBeforeItsTimeAndNothingAfterIt) {
    plan(FaultKind::lost_reply, 2);
    wire(FaultyWire::Kind::rtu);
    EXPECT_EQ(ask(1), reply(1));
    EXPECT_EQ(ask(2), Bytes());
    EXPECT_EQ(ask(3), reply(3));
    ASSERT_EQ(told_.size(), 1U);
    EXPECT_EQ(told_[0].substr(0, 44), "fault lost_reply after 0 samples, 2 requests");
}

TEST_F(FaultyWireTest, ADelayedReplyComesLaterAndNothingOvertakesIt) {
    plan(FaultKind::delay, 1, 50.0);
    wire(FaultyWire::Kind::tcp);
    EXPECT_EQ(ask(1), Bytes());
    EXPECT_EQ(ask(2), Bytes());
    EXPECT_EQ(later(49), Bytes());
    EXPECT_EQ(later(1), together(reply(1), reply(2)));
}

TEST_F(FaultyWireTest, ASplitReplyComesInTwoHalves) {
    plan(FaultKind::split, 1, 20.0);
    wire(FaultyWire::Kind::line);
    EXPECT_EQ(ask(1), Bytes(4, 1));
    EXPECT_EQ(later(20), Bytes(4, 1));
}

TEST_F(FaultyWireTest, TruncatedDuplicatedStale) {
    for (const auto& [kind, expected] :
         {std::pair(FaultKind::truncated, Bytes(4, 2)), std::pair(FaultKind::duplicated, together(reply(2), reply(2))),
          std::pair(FaultKind::stale, reply(1))}) {
        plan(kind, 2);
        wire(FaultyWire::Kind::rtu);
        EXPECT_EQ(ask(1), reply(1));
        EXPECT_EQ(ask(2), expected) << to_string(kind);
        EXPECT_EQ(ask(3), reply(3));
    }
}

TEST_F(FaultyWireTest, MergedAndReorderedComeWithTheNextOne) {
    for (const auto kind : {FaultKind::merged, FaultKind::reordered}) {
        plan(kind, 1);
        wire(FaultyWire::Kind::tcp);
        EXPECT_EQ(ask(1), Bytes());
        EXPECT_EQ(ask(2), kind == FaultKind::merged ? together(reply(1), reply(2)) : together(reply(2), reply(1)));
        EXPECT_EQ(ask(3), reply(3));
    }
}

TEST_F(FaultyWireTest, OneByteIsSpoilt) {
    plan(FaultKind::bad_crc, 1);
    wire(FaultyWire::Kind::rtu);
    const Bytes got = ask(1);
    ASSERT_EQ(got.size(), 8U);
    EXPECT_EQ(std::count(got.begin(), got.end(), 1), 7);
}

TEST_F(FaultyWireTest, ACableThatIsOutKeepsTcpWaitingAndLosesSerialBytes) {
    plan(FaultKind::cable, 1, 0.0, 0.1);
    wire(FaultyWire::Kind::tcp);
    EXPECT_EQ(ask(1), Bytes());
    EXPECT_EQ(ask(2), Bytes());
    EXPECT_EQ(later(99), Bytes());
    EXPECT_EQ(later(2), reply(1));
    EXPECT_EQ(in_.size(), 4U) << "the second request waits in the stream";
    plan(FaultKind::cable, 1, 0.0, 0.1);
    wire(FaultyWire::Kind::rtu);
    in_.clear();
    EXPECT_EQ(ask(1), Bytes());
    EXPECT_EQ(ask(2), Bytes());
    EXPECT_TRUE(in_.empty());
    EXPECT_EQ(later(101), Bytes());
    EXPECT_EQ(ask(3), reply(3));
}

TEST_F(FaultyWireTest, HalfOpenIsSilentForGoodOnThisConnectionOnly) {
    plan(FaultKind::half_open, 1);
    wire(FaultyWire::Kind::tcp);
    EXPECT_EQ(ask(1), Bytes());
    EXPECT_EQ(ask(2), Bytes());
    EXPECT_TRUE(progress_.alive);
    wire(FaultyWire::Kind::tcp);
    EXPECT_EQ(ask(3), reply(3));
}

TEST_F(FaultyWireTest, ClosedEndsTheConnectionAndKeepsAPortAway) {
    plan(FaultKind::closed, 1, 0.0, 0.2);
    wire(FaultyWire::Kind::line);
    EXPECT_EQ(ask(1), Bytes());
    EXPECT_FALSE(progress_.alive);
    EXPECT_EQ(progress_.away, std::chrono::milliseconds(200));
}

TEST_F(FaultyWireTest, ARestartKillsOlderConnections) {
    plan(FaultKind::restart, 1);
    wire(FaultyWire::Kind::tcp);
    const auto boot = rig_.controller.options().boot_id;
    ask(1);
    EXPECT_EQ(rig_.controller.options().boot_id, boot + 1);
    later(1);
    EXPECT_FALSE(progress_.alive);
    wire(FaultyWire::Kind::tcp);
    EXPECT_EQ(ask(2), reply(2));
}

TEST_F(FaultyWireTest, RequestsGetLostAndOverrun) {
    plan(FaultKind::lost_request, 1);
    wire(FaultyWire::Kind::rtu);
    EXPECT_EQ(ask(1), reply(1)) << "the first request sets the count";
    EXPECT_EQ(ask(2), Bytes());
    EXPECT_TRUE(in_.empty());
    plan(FaultKind::overrun, 1, 3.0);
    wire(FaultyWire::Kind::rtu);
    EXPECT_EQ(ask(1), reply(1));
    EXPECT_EQ(ask(2), Bytes());
    EXPECT_EQ(in_, Bytes(1, 2));
}

TEST_F(FaultyWireTest, RatesAreKept) {
    plan(FaultKind::dropped_bytes, 1, 0.1);
    wire(FaultyWire::Kind::rtu);
    Bytes all;
    for (int k = 0; k < 1000; ++k)
        all = together(all, ask(7));
    // 4000 bytes in and 8000 out at one in ten; some requests are never whole.
    EXPECT_EQ(std::count(all.begin(), all.end(), 7), static_cast<std::ptrdiff_t>(all.size()));
    const double share = static_cast<double>(all.size()) / (0.9 * 8000.0 * 0.9);
    EXPECT_NEAR(share, 1.0, 0.05);
}

}  // namespace
}  // namespace cmm::sim::test
