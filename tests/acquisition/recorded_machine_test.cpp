// SPDX-License-Identifier: Apache-2.0
// What a run file says of the machine, also files of older versions and of strangers.
#include "acquisition/recorded_machine.hpp"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include "acquisition/recording.hpp"
#include "tests/acquisition/temp_folder.hpp"

namespace cmm::acquisition {
namespace {

drivers::Capabilities machine() {
    drivers::Capabilities machine;
    machine.model = "CMM";
    machine.serial = "7";
    machine.boot_id = 42;
    machine.lsb_mm = 1e-4;
    machine.moves = true;
    machine.scans_paths = machine.appends_paths = true;
    machine.sample_rate_hz = 1000.0;
    machine.fifo_depth = 8192;
    machine.path_capacity = 4096;
    machine.path_window = 10;
    machine.deflection_lsb_mm = 1e-5;
    machine.limit_min_mm = {-500.1, -400.2, -100.3};
    machine.limit_max_mm = {1.0 / 3.0, 400.0, 700.0};
    machine.max_speed_mm_s = 400.0;
    machine.max_acceleration_mm_s2 = 1500.0;
    machine.watchdog_ms = 500.0;
    return machine;
}

struct RecordedMachineTest : testing::Test {
    TempFolder folder;
    std::string file = folder.path("run.cmmrun");

    void SetUp() override {
        Journal::Header header;
        header.machine_model = "CMM";
        header.machine_serial = "7";
        header.plan_hash = "abc";
        header.lsb_mm = 1e-4;
        header.boot_id = 42;
        header.capabilities = capability_numbers(machine());
        auto journal = Journal::create(file, header);
        ASSERT_TRUE(journal) << journal.error().text();
        ASSERT_TRUE((*journal)->begin_path({1, 0, 0, false}));
        core::Sample sample;
        sample.sequence = 1;
        sample.path = 1;
        ASSERT_TRUE((*journal)->append(std::span(&sample, 1)));
        ASSERT_TRUE((*journal)->finish_run("accept"));
    }
    void sql(const char* text) const {
        sqlite3* db = nullptr;
        ASSERT_EQ(sqlite3_open(file.c_str(), &db), SQLITE_OK);
        EXPECT_EQ(sqlite3_exec(db, text, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
        sqlite3_close(db);
    }
};

TEST_F(RecordedMachineTest, ComesBackToTheLastBitAndAnswersItsPlanOnly) {
    const auto recording = Recording::load(file);
    ASSERT_TRUE(recording) << recording.error().text();
    const auto found = recorded_capabilities(recording->header());
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_EQ(capability_numbers(*found), capability_numbers(machine()));
    EXPECT_EQ(found->limit_max_mm, machine().limit_max_mm);
    EXPECT_EQ(found->path_window, 10U);
    EXPECT_TRUE(found->scans_paths);
    EXPECT_FALSE(found->touches);
    EXPECT_EQ(found->model, "CMM");
    EXPECT_EQ(found->boot_id, 42U);
    EXPECT_EQ(found->lsb_mm, 1e-4);
    EXPECT_EQ(found->recorded_plan, "abc");
}

TEST_F(RecordedMachineTest, AFileOfVersion1IsReadButCannotBePlayed) {
    sql("DROP TABLE capability; DROP TABLE part_frame; ALTER TABLE path DROP COLUMN pass; PRAGMA user_version = 1");
    const auto recording = Recording::load(file);
    ASSERT_TRUE(recording) << recording.error().text();
    EXPECT_EQ(recording->size(), 1U);
    const auto found = recorded_capabilities(recording->header());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, core::ErrorCode::input_invalid);
    EXPECT_NE(found.error().message.find("older version"), std::string::npos) << found.error().message;
    // Gone on with, it becomes a file of this version.
    ASSERT_TRUE(Journal::open(file));
    EXPECT_TRUE(Journal::read(file));
}

TEST_F(RecordedMachineTest, AFileThatHoldsStatementsIsRefused) {
    sql("ALTER TABLE batch RENAME TO hidden; CREATE VIEW batch AS SELECT * FROM hidden");
    for (const auto& result : {Journal::read(file), Journal::open(file)}) {
        ASSERT_FALSE(result);
        EXPECT_EQ(result.error().code, core::ErrorCode::journal_corrupt);
        EXPECT_NE(result.error().message.find("views or triggers"), std::string::npos) << result.error().message;
    }
}

TEST_F(RecordedMachineTest, ASampleOfAPathThatNeverBeganIsNamed) {
    sql("DELETE FROM path");
    const auto recording = Recording::load(file);
    ASSERT_FALSE(recording);
    EXPECT_NE(recording.error().message.find("never begun"), std::string::npos) << recording.error().message;
}

}  // namespace
}  // namespace cmm::acquisition
