// SPDX-License-Identifier: Apache-2.0
#include "cell/cell.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace cmm::cell {
namespace {

using namespace std::chrono_literals;
namespace bit = command_bit;

/// A cell, the PLC before it, and a service behind it that answers when the test says so.
class CellTest : public ::testing::Test {
  protected:
    CellTest() { begin({}); }

    void begin(const CellRecord& restored) {
        CellOptions options;
        options.programs = {3, 4};
        options.watchdog = 2s;
        options.restored = restored;
        CellHost host;
        host.record = [this](const CellRecord& record) { records.push_back(record); };
        host.run = [this](const Order& order) { runs.push_back(order); };
        host.stop = [this] { ++stops; };
        cell = std::make_unique<Cell>(options, host);
        command = 0;
    }
    /// As PLCs do it: the whole block every few milliseconds.
    ModbusException cycle(core::Duration later = 100ms) {
        now += later;
        ++beat;
        std::vector<std::uint16_t> words{beat, command, program, 0, 0x534E, 0x3137};
        const auto outcome = cell->write(0, words, now);
        cell->tick(now);
        return outcome;
    }
    void ask(unsigned bits) {
        command = static_cast<std::uint16_t>(bits);
        EXPECT_EQ(cycle(), ModbusException::none);
    }
    void silence(core::Duration time) {
        for (core::Duration gone{0}; gone < time; gone += 20ms)
            cell->tick(now += 20ms);
    }
    std::uint16_t read(CellBlock::At place) const {
        std::uint16_t value = 0;
        EXPECT_EQ(cell->read(CellBlock::first + place, {&value, 1}), ModbusException::none);
        return value;
    }
    bool status(std::uint16_t asked) const { return (read(CellBlock::status) & asked) != 0; }
    unsigned run_number() const {
        return static_cast<unsigned>(read(CellBlock::run) << 16U |
                                     read(static_cast<CellBlock::At>(CellBlock::run + 1)));
    }
    void to_busy() {
        ask(bit::part_present);
        ASSERT_TRUE(status(status_bit::ready));
        ask(bit::part_present | bit::start);
        cell->recorded();
        ASSERT_EQ(cell->view().state, CellState::busy);
    }
    void acknowledge() {
        ask(bit::part_present | bit::acknowledge);
        cell->recorded();
        EXPECT_FALSE(status(status_bit::done));
        ask(0);
    }
    static CellResult result_of(std::uint16_t value) { return static_cast<CellResult>(value); }

    core::Duration now = 10s;
    std::uint16_t beat = 0, command = 0, program = 3;
    std::unique_ptr<Cell> cell;
    std::vector<CellRecord> records;
    std::vector<Order> runs;
    int stops = 0;
};

TEST_F(CellTest, OnePartFromStartToAcknowledgement) {
    EXPECT_FALSE(status(status_bit::ready)) << "no PLC yet";
    ask(bit::part_present);
    EXPECT_TRUE(status(status_bit::ready));
    ask(bit::part_present | bit::start);
    EXPECT_TRUE(status(status_bit::busy));
    EXPECT_TRUE(runs.empty()) << "not before the start is on the disk";
    ASSERT_EQ(records.size(), 1U);
    EXPECT_EQ(records[0].phase, CellRecord::Phase::measuring);
    cell->recorded();
    ASSERT_EQ(runs.size(), 1U);
    EXPECT_EQ(runs[0].run, 1U);
    EXPECT_EQ(runs[0].program, 3);
    EXPECT_EQ(runs[0].serial, "SN17");
    EXPECT_EQ(read(CellBlock::program), 3);
    EXPECT_EQ(read(CellBlock::serial), 0x534E);
    EXPECT_TRUE(status(status_bit::may_be_moving));
    ask(bit::part_present);
    cell->progress(0.25, 2);
    EXPECT_EQ(read(CellBlock::progress), 250);
    EXPECT_EQ(read(CellBlock::section), 2);
    cell->ended({CellResult::accepted, Reason::conforming, false});
    EXPECT_TRUE(status(status_bit::busy)) << "not done before the result is on the disk";
    EXPECT_EQ(read(CellBlock::result), 0);
    EXPECT_EQ(records.back().outcome.result, CellResult::accepted);
    cell->recorded();
    EXPECT_TRUE(status(status_bit::done));
    EXPECT_FALSE(status(status_bit::busy | status_bit::may_be_moving));
    EXPECT_EQ(result_of(read(CellBlock::result)), CellResult::accepted);
    EXPECT_EQ(read(CellBlock::reason), 1);
    silence(10min);
    EXPECT_TRUE(status(status_bit::done)) << "the result stays until it is acknowledged";
    ask(bit::part_present | bit::acknowledge);
    EXPECT_TRUE(status(status_bit::done)) << "nor taken back before that is on the disk";
    cell->recorded();
    EXPECT_FALSE(status(status_bit::done | status_bit::ready)) << "acknowledge is still there";
    EXPECT_EQ(read(CellBlock::result), 0);
    ask(0);
    EXPECT_TRUE(status(status_bit::ready));
    EXPECT_EQ(runs.size(), 1U);
}

TEST_F(CellTest, AStartThatStaysIsOnePart) {
    to_busy();
    cell->ended({CellResult::accepted, Reason::conforming, false});
    cell->recorded();
    ask(bit::part_present | bit::start | bit::acknowledge);
    cell->recorded();
    for (int i = 0; i < 10; ++i)
        ask(bit::part_present | bit::start);
    EXPECT_FALSE(status(status_bit::ready));
    EXPECT_EQ(runs.size(), 1U);
    ask(bit::part_present);
    ask(bit::part_present | bit::start);
    cell->recorded();
    ASSERT_EQ(runs.size(), 2U);
    EXPECT_EQ(runs[1].run, 2U);
}

TEST_F(CellTest, ARejectionIsTherePromptlyAndStays) {
    to_busy();
    cell->rejected_for_certain(4);
    EXPECT_EQ(result_of(read(CellBlock::decision)), CellResult::rejected);
    EXPECT_EQ(read(CellBlock::decided_section), 4);
    EXPECT_TRUE(status(status_bit::rejected_for_certain));
    EXPECT_EQ(read(CellBlock::result), 0) << "the machine may still move: not done";
    // Whatever ends the run now, the part is out.
    ask(bit::part_present | bit::abort);
    EXPECT_EQ(stops, 1);
    cell->ended({CellResult::error, Reason::stopped_at_host, false});
    cell->recorded();
    EXPECT_EQ(result_of(read(CellBlock::result)), CellResult::rejected);
    EXPECT_EQ(static_cast<Reason>(read(CellBlock::reason)), Reason::aborted);
    acknowledge();
    EXPECT_EQ(read(CellBlock::decision), 0);
    EXPECT_FALSE(status(status_bit::rejected_for_certain));
}

TEST_F(CellTest, WhatStopsARun) {
    const auto stop_by = [&](const std::function<void()>& cause) {
        to_busy();
        const int before = stops;
        cause();
        EXPECT_EQ(stops, before + 1);
        cause();
        EXPECT_EQ(stops, before + 1) << "once";
        EXPECT_TRUE(status(status_bit::may_be_moving)) << "until the machine has said that it rests";
        // Also when the run had just come to its end: somebody asked for a stop and gets no verdict.
        cell->ended({CellResult::accepted, Reason::conforming, false});
        cell->recorded();
        EXPECT_EQ(result_of(read(CellBlock::result)), CellResult::error);
        const auto reason = static_cast<Reason>(read(CellBlock::reason));
        acknowledge();
        return reason;
    };
    EXPECT_EQ(stop_by([&] { ask(bit::part_present | bit::abort); }), Reason::aborted);
    EXPECT_EQ(stop_by([&] { ask(0); }), Reason::part_removed);
    EXPECT_EQ(stop_by([&] { silence(2500ms); }), Reason::plc_silent);
    EXPECT_EQ(cell->view().plc_losses, 1U);
    EXPECT_EQ(stop_by([&] { cell->shut_down(); }), Reason::service_stopped);
    EXPECT_TRUE(cell->at_rest());
}

TEST_F(CellTest, ALostConnectionShorterThanTheWatchdogChangesNothing) {
    to_busy();
    silence(1900ms);
    ask(bit::part_present);
    EXPECT_EQ(stops, 0);
    EXPECT_EQ(read(CellBlock::plc_heartbeat), beat);
    cell->ended({CellResult::undecided, Reason::undecided, false});
    cell->recorded();
    EXPECT_EQ(result_of(read(CellBlock::result)), CellResult::undecided);
}

TEST_F(CellTest, AStopBeforeTheStartIsOnTheDiskMovesNothing) {
    ask(bit::part_present);
    ask(bit::part_present | bit::start);
    ask(bit::part_present | bit::abort);
    ask(bit::part_present);
    cell->recorded();
    EXPECT_TRUE(runs.empty());
    EXPECT_EQ(stops, 0);
    cell->recorded();
    EXPECT_TRUE(status(status_bit::done));
    EXPECT_EQ(static_cast<Reason>(read(CellBlock::reason)), Reason::aborted);
}

TEST_F(CellTest, AStartThatCannotBeCarriedOutHasAResultToo) {
    const auto refused = [&](unsigned bits) {
        ask(bits & ~unsigned{bit::start});
        ask(bits);
        cell->recorded();
        EXPECT_TRUE(status(status_bit::done));
        EXPECT_EQ(result_of(read(CellBlock::result)), CellResult::error);
        const auto reason = static_cast<Reason>(read(CellBlock::reason));
        acknowledge();
        return reason;
    };
    EXPECT_EQ(refused(bit::start), Reason::no_part);
    program = 5;
    EXPECT_EQ(refused(bit::part_present | bit::start), Reason::no_program);
    program = 3;
    now += 100ms;
    const std::vector<std::uint16_t> serial{0x220A};
    ASSERT_EQ(cell->write(PlcBlock::serial + 2, serial, now), ModbusException::none);
    EXPECT_EQ(refused(bit::part_present | bit::start), Reason::serial_invalid);
    EXPECT_TRUE(runs.empty());
    EXPECT_EQ(run_number(), 3U) << "each start has its number";
}

TEST_F(CellTest, ASilentPlcAndOneThatAbortsAreNotTakenFor) {
    ask(bit::part_present);
    silence(3s);
    EXPECT_FALSE(status(status_bit::ready | status_bit::plc_lives));
    ask(bit::part_present | bit::abort | bit::start);
    EXPECT_FALSE(status(status_bit::ready));
    EXPECT_TRUE(records.empty());
    ask(bit::part_present);
    EXPECT_TRUE(status(status_bit::ready));
}

TEST_F(CellTest, AServiceThatWasKilledTellsWhatItKnows) {
    begin({CellRecord::Phase::done, {7, 4, "A1"}, {CellResult::rejected, Reason::out_of_tolerance, false}});
    EXPECT_TRUE(status(status_bit::done));
    EXPECT_EQ(run_number(), 7U);
    EXPECT_EQ(read(CellBlock::serial), 0x4131);
    EXPECT_EQ(result_of(read(CellBlock::result)), CellResult::rejected);
    acknowledge();
    EXPECT_EQ(records.back().phase, CellRecord::Phase::cleared);
    EXPECT_EQ(records.back().order.run, 7U);

    begin({CellRecord::Phase::measuring, {8, 4, "A2"}, {}});
    EXPECT_TRUE(status(status_bit::done));
    EXPECT_EQ(static_cast<Reason>(read(CellBlock::reason)), Reason::service_restarted);

    begin({CellRecord::Phase::cleared, {9, 4, "A3"}, {CellResult::accepted, Reason::conforming, false}});
    EXPECT_FALSE(status(status_bit::done));
    // The PLC has not seen that its acknowledgement arrived, and its start stands from before.
    runs.clear();
    for (int i = 0; i < 5; ++i)
        ask(bit::part_present | bit::start | bit::acknowledge);
    ask(bit::part_present | bit::start);
    EXPECT_FALSE(status(status_bit::ready | status_bit::busy)) << "one part is not measured twice";
    ask(bit::part_present);
    ask(bit::part_present | bit::start);
    cell->recorded();
    ASSERT_EQ(runs.size(), 1U);
    EXPECT_EQ(runs[0].run, 10U);
}

TEST_F(CellTest, TheFirstHeartbeatAloneIsNoNeutralCommand) {
    now += 100ms;
    const std::vector<std::uint16_t> one{1}, two{2}, start{bit::part_present | bit::start};
    cell->write(PlcBlock::heartbeat, one, now);
    cell->write(PlcBlock::heartbeat, two, now);
    EXPECT_FALSE(status(status_bit::ready)) << "registers of a fresh service are 0, the PLC's may not be";
    cell->write(PlcBlock::command, start, now);
    EXPECT_FALSE(status(status_bit::ready | status_bit::busy));
}

TEST_F(CellTest, ItsHeartbeatGoesOn) {
    const auto before = read(CellBlock::heartbeat);
    silence(1s);
    EXPECT_GE(read(CellBlock::heartbeat) - before, 8);
    EXPECT_EQ(read(CellBlock::watchdog_ms), 2000);
}

TEST_F(CellTest, WhatARunWaitsForIsToldWhileItWaits) {
    cell->held(reason_of(core::ErrorCode::machine_door));
    EXPECT_FALSE(status(status_bit::held)) << "nothing runs";
    to_busy();
    cell->held(reason_of(std::string_view("machine_door")));
    EXPECT_TRUE(status(status_bit::held));
    EXPECT_TRUE(status(status_bit::may_be_moving)) << "it goes on by itself";
    EXPECT_EQ(read(CellBlock::reason), 408);
    EXPECT_EQ(read(CellBlock::result), 0);
    cell->held(Reason::none);
    EXPECT_FALSE(status(status_bit::held));
    EXPECT_EQ(read(CellBlock::reason), 0);
    cell->held(reason_of(core::ErrorCode::journal_full));
    cell->ended({CellResult::error, reason_of(core::ErrorCode::journal_full), false});
    cell->recorded();
    EXPECT_FALSE(status(status_bit::held));
    EXPECT_EQ(read(CellBlock::reason), 601);
}

TEST_F(CellTest, ThatTheMachineMayMoveIsToldWithTheResult) {
    to_busy();
    cell->ended({CellResult::error, reason_of(core::ErrorCode::transport_closed), true});
    cell->recorded();
    EXPECT_TRUE(status(status_bit::done));
    EXPECT_TRUE(status(status_bit::may_be_moving));
    EXPECT_EQ(read(CellBlock::reason), 502);
}

}  // namespace
}  // namespace cmm::cell
