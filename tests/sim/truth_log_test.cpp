// SPDX-License-Identifier: Apache-2.0
#include "sim/truth_log.hpp"

#include <gtest/gtest.h>

#include "tests/sim/temporary_file.hpp"

namespace cmm::sim::test {
namespace {

constexpr std::string_view header =
    "boot_id,seq,path,index,t_us,x_counts,y_counts,z_counts,true_x_mm,true_y_mm,true_z_mm,noise_um,bad_um,flags\n";

SampleTruth sample(std::uint32_t seq) {
    SampleTruth truth;
    truth.sample = {seq, 3, 123456, {10, -20, 30}, quality::no_contact};
    truth.index = 4;
    truth.centre_mm = {0.0010001, -0.002, 0.003};
    truth.noise_mm = 0.0005;
    truth.bad_mm = -0.1;
    return truth;
}

TEST(TruthLog, OneRowPerSampleAppendedOverRuns) {
    const TemporaryFile file("");
    for (std::uint16_t boot = 5; boot <= 6; ++boot) {
        auto log = TruthLog::open(file.path());
        ASSERT_TRUE(log);
        (*log)->write(sample(1), boot);
    }
    const std::string row = ",1,3,4,123456,10,-20,30,0.0010001,-0.0020000,0.0030000,0.5000,-100.0000,1\n";
    EXPECT_EQ(file.content(), std::string(header) + "5" + row + "6" + row);
}

TEST(TruthLog, IsOnDiskAfterATenthOfASecond) {
    const TemporaryFile file("");
    auto log = TruthLog::open(file.path());
    ASSERT_TRUE(log);
    (*log)->flush_if_due(std::chrono::milliseconds(1000));
    (*log)->write(sample(1), 5);
    (*log)->flush_if_due(std::chrono::milliseconds(1099));
    EXPECT_EQ(file.content(), header);
    (*log)->flush_if_due(std::chrono::milliseconds(1100));
    EXPECT_GT(file.content().size(), header.size() + 20);
}

TEST(TruthLog, AFolderThatIsNotThere) {
    const auto log = TruthLog::open("no/such/folder/log.csv");
    ASSERT_FALSE(log);
    EXPECT_EQ(log.error().code, core::ErrorCode::journal_io);
}

}  // namespace
}  // namespace cmm::sim::test
