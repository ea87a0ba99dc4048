// SPDX-License-Identifier: Apache-2.0
// Real blades through the whole chain over Modbus TCP, with and without a nominal.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "tests/system/real_parts_run.hpp"

namespace cmm::test {
namespace {

constexpr double contour_limit_mm = 0.030;
constexpr double good_lost_share = 0.002;

class RealParts : public testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(RealParts, ComeOutTrue) {
    if (real_data_folder().empty()) GTEST_SKIP() << "no ../shared/data here";
    const auto [index, unknown] = GetParam();
    const TemporaryFolder folder;
    const auto part = real_parts(folder).at(static_cast<std::size_t>(index));
    const auto run = run_real_part(part, unknown, 40 + index);
    ASSERT_TRUE(run.failure.empty()) << run.failure;
    std::printf("%-17s %-8s %s\n", part.name.c_str(), unknown ? "unknown" : "nominal", run.text().c_str());
    EXPECT_EQ(run.closed, part.heights_mm.size());
    EXPECT_EQ(run.four_zones, part.heights_mm.size());
    EXPECT_LE(run.contour.worst_mm, contour_limit_mm);
    EXPECT_GT(run.points.bad, 0U);
    EXPECT_EQ(run.points.bad_missed, 0U);
    EXPECT_LE(static_cast<double>(run.points.good_lost), good_lost_share * static_cast<double>(run.points.good));
}

std::string case_name(const testing::TestParamInfo<std::tuple<int, bool>>& tested) {
    const std::array<const char*, 4> names{"EngineBlade", "HannoverRotor1", "HannoverStator1", "Rotor37"};
    return std::string(names.at(static_cast<std::size_t>(std::get<0>(tested.param)))) +
           (std::get<1>(tested.param) ? "Unknown" : "Nominal");
}

INSTANTIATE_TEST_SUITE_P(Blades, RealParts, testing::Combine(testing::Range(0, 4), testing::Bool()), case_name);

}  // namespace
}  // namespace cmm::test
