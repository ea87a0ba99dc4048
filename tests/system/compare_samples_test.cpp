// SPDX-License-Identifier: Apache-2.0
// The judge of what was lost or doubled.
#include "tests/system/compare_samples.hpp"

#include <gtest/gtest.h>

namespace cmm::test {
namespace {

std::vector<Counts> points(std::initializer_list<int> xs) {
    std::vector<Counts> all;
    for (const int x : xs)
        all.push_back({x, 0, 0});
    return all;
}

TEST(CompareSamples, EachOnceAndInOrderIsWell) {
    EXPECT_EQ(compare_counts(points({1, 2, 3}), {points({1, 2, 3})}), "");
    EXPECT_EQ(compare_counts({}, {}), "");
}

TEST(CompareSamples, OneLostDoubledOrInventedIsNot) {
    for (const auto& wrong : {points({1, 2}), points({1, 3}), points({2, 3}), points({1, 2, 2, 3}), points({1, 3, 2}),
                              points({1, 2, 3, 4}), points({})})
        EXPECT_NE(compare_counts(wrong, {points({1, 2, 3})}), "") << wrong.size();
    EXPECT_NE(compare_counts(points({1}), {}), "");
}

TEST(CompareSamples, ARestartedControllerMayHaveForgottenItsLast) {
    const std::vector starts{points({1, 2, 3}), points({3, 4})};
    EXPECT_EQ(compare_counts(points({1, 2, 3, 3, 4}), starts), "");
    EXPECT_EQ(compare_counts(points({1, 2, 3, 4}), starts), "") << "measured again, to the same counts";
    EXPECT_EQ(compare_counts(points({3, 4}), starts), "");
    EXPECT_NE(compare_counts(points({1, 3, 3, 4}), starts), "") << "not the first part of it";
    EXPECT_NE(compare_counts(points({1, 2, 3, 3}), starts), "");
    EXPECT_NE(compare_counts(points({1, 2, 3, 3, 4, 4}), starts), "");
}

}  // namespace
}  // namespace cmm::test
