// SPDX-License-Identifier: Apache-2.0
// A few runs of the fault matrix; ./run faults makes all of them.
#include "tests/system/fault_matrix.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace cmm::test {
namespace {

struct Sample {
    const char* fault;
    Wire wire;
};

class FaultMatrix : public testing::TestWithParam<Sample> {};

TEST_P(FaultMatrix, NothingIsLostAndTheJobIsDoneInTheEnd) {
    const auto cases = fault_cases();
    const auto fault =
        std::find_if(cases.begin(), cases.end(), [](const FaultCase& entry) { return entry.name == GetParam().fault; });
    ASSERT_NE(fault, cases.end());
    const TemporaryFolder folder;
    const FaultRun run = run_fault(*fault, GetParam().wire, 1, folder);
    EXPECT_TRUE(run.struck);
    EXPECT_TRUE(run.good()) << run.text();
}

INSTANTIATE_TEST_SUITE_P(Sample, FaultMatrix,
                         testing::Values(Sample{"emergency-stop", Wire::line}, Sample{"restart", Wire::rtu},
                                         Sample{"stale", Wire::rtu}, Sample{"reordered", Wire::tcp},
                                         Sample{"disk-full", Wire::tcp}, Sample{"door-waited-for", Wire::rtu},
                                         Sample{"temperature-waited-for", Wire::tcp},
                                         Sample{"disk-full-waited-for", Wire::line}),
                         [](const auto& sample) {
                             std::string name = sample.param.fault + std::string("Over") + to_string(sample.param.wire);
                             std::erase(name, '-');
                             return name;
                         });

}  // namespace
}  // namespace cmm::test
