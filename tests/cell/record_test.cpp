// SPDX-License-Identifier: Apache-2.0
#include "cell/record.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace cmm::cell {
namespace {

class RecordTest : public ::testing::Test {
  protected:
    RecordTest() {
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
    }
    ~RecordTest() override { std::filesystem::remove_all(folder); }
    void write(const std::string& text) const { std::ofstream(file) << text; }

    std::string folder = ::testing::TempDir() + "/cell-record-" + std::to_string(::getpid());
    std::string file = folder + "/cell.json";
};

TEST_F(RecordTest, IsReadBackAsItWasWritten) {
    CellRecord record;
    record.phase = CellRecord::Phase::done;
    record.order = {70000, 12, "SN 4711/b"};
    record.outcome = {CellResult::rejected, Reason::out_while_measuring, true};
    ASSERT_TRUE(save_record(file, record));
    const auto loaded = load_record(file);
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_EQ(loaded->phase, record.phase);
    EXPECT_EQ(loaded->order.run, 70000U);
    EXPECT_EQ(loaded->order.program, 12);
    EXPECT_EQ(loaded->order.serial, "SN 4711/b");
    EXPECT_EQ(loaded->outcome.result, CellResult::rejected);
    EXPECT_EQ(loaded->outcome.reason, Reason::out_while_measuring);
    EXPECT_TRUE(loaded->outcome.may_be_moving);
}

TEST_F(RecordTest, NoFileIsNoPartYet) {
    const auto loaded = load_record(file);
    ASSERT_TRUE(loaded);
    EXPECT_EQ(loaded->phase, CellRecord::Phase::cleared);
    EXPECT_EQ(loaded->order.run, 0U);
}

TEST_F(RecordTest, ADamagedFileIsRefusedAndNotTakenForAnEmptyOne) {
    const std::string good =
        R"({"may_be_moving":false,"phase":"done","program":1,"reason":1,"result":1,"run":5,"serial":"a"})";
    write(good);
    EXPECT_TRUE(load_record(file));
    for (const auto& [from, to] :
         std::vector<std::pair<std::string, std::string>>{{"done", "gone"},
                                                          {"\"result\":1", "\"result\":6"},
                                                          {"\"run\":5", "\"run\":\"5\""},
                                                          {"\"serial\":\"a\"", "\"serial\":\"\\n\""},
                                                          {"}", ""}}) {
        std::string bad = good;
        bad.replace(bad.find(from), from.size(), to);
        write(bad);
        const auto loaded = load_record(file);
        ASSERT_FALSE(loaded) << bad;
        EXPECT_EQ(loaded.error().code, core::ErrorCode::input_invalid);
    }
}

TEST_F(RecordTest, AFolderThatIsGoneIsAnError) {
    const auto saved = save_record(folder + "/none/cell.json", {});
    ASSERT_FALSE(saved);
    EXPECT_EQ(saved.error().code, core::ErrorCode::journal_io);
}

}  // namespace
}  // namespace cmm::cell
