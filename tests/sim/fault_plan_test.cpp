// SPDX-License-Identifier: Apache-2.0
#include "sim/fault_plan.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/sim/temporary_file.hpp"

namespace cmm::sim::test {
namespace {

TEST(FaultPlan, ReadsWhatWhenAndHowMuch) {
    const TemporaryFile file(
        "seed = 9\n[[fault]]\nwhat = \"door\"\nsamples = [10, 20]\nfor_s = 0.5\nagain = true\n"
        "[[fault]]\nwhat = \"delay\"\nrequests = 7\nms = 250\ntimes = 3\n");
    const auto plan = load_fault_plan(file.path());
    ASSERT_TRUE(plan) << plan.error().text();
    EXPECT_EQ(plan->seed, 9U);
    ASSERT_EQ(plan->faults.size(), 2U);
    const Fault& door = plan->faults[0];
    EXPECT_EQ(door.kind, FaultKind::door);
    EXPECT_EQ(door.when.count, FaultTime::Count::samples);
    EXPECT_EQ(door.when.from, 10.0);
    EXPECT_EQ(door.when.to, 20.0);
    EXPECT_EQ(door.for_s, 0.5);
    EXPECT_TRUE(door.again);
    const Fault& delay = plan->faults[1];
    EXPECT_EQ(delay.when.count, FaultTime::Count::requests);
    EXPECT_EQ(delay.when.from, 7.0);
    EXPECT_EQ(delay.when.to, 7.0);
    EXPECT_EQ(delay.amount, 250.0);
    EXPECT_EQ(delay.times, 3);
}

struct Bad {
    const char* text;
    const char* place;  // line:column
    const char* expected;
};

class FaultPlanBad : public testing::TestWithParam<Bad> {};

TEST_P(FaultPlanBad, IsSaidWithItsPlace) {
    const TemporaryFile file(GetParam().text);
    const auto plan = load_fault_plan(file.path());
    ASSERT_FALSE(plan);
    EXPECT_NE(plan.error().message.find(file.path() + ":" + GetParam().place), std::string::npos)
        << plan.error().message;
    EXPECT_NE(plan.error().message.find(GetParam().expected), std::string::npos) << plan.error().message;
}

INSTANTIATE_TEST_SUITE_P(
    Values, FaultPlanBad,
    testing::Values(Bad{"[[fault]]\nwhat = \"earthquake\"\nsamples = 1\n", "2:", "must be one of"},
                    Bad{"[[fault]]\nwhat = \"drit\"\nsamples = 1\num = 4\n", "2:", "must be one of"},
                    Bad{"\n[[fault]]\nsamples = 1\n", "2:", "is missing"},
                    Bad{"[[fault]]\nwhat = \"door\"\n", "2:", "samples, requests, seconds"},
                    Bad{"[[fault]]\nwhat = \"door\"\nsamples = 1\nseconds = 2\n", "2:", "one of samples"},
                    Bad{"[[fault]]\nwhat = \"door\"\nsamples = [3, 1]\n", "3:", "the smaller first"},
                    Bad{"[[fault]]\nwhat = \"door\"\nsamples = \"soon\"\n", "3:", "must be a number"},
                    Bad{"[[fault]]\nwhat = \"dirt\"\nsamples = 1\nms = 4\n", "4:", "unknown key"},
                    Bad{"[[fault]]\nwhat = \"delay\"\nsamples = 1\nms = -4\n", "4:", "from 0 to 60000"},
                    Bad{"fault = 3\n", "1:", "list of tables"}, Bad{"[[fault]\n", "1:", ""}));

TEST(FaultPlan, EveryPlanThatComesWithTheProgramHolds) {
    int plans = 0;
    for (const auto& entry : std::filesystem::directory_iterator("config/faults")) {
        const auto plan = load_fault_plan(entry.path().string());
        EXPECT_TRUE(plan) << plan.error().text();
        EXPECT_FALSE(plan && plan->faults.empty()) << entry.path();
        ++plans;
    }
    EXPECT_GT(plans, 40);
}

}  // namespace
}  // namespace cmm::sim::test
