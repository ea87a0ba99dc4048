// SPDX-License-Identifier: Apache-2.0
#include "acquisition/operator_choice.hpp"

#include <gtest/gtest.h>

namespace cmm::acquisition {
namespace {

using fitting::RejectReason;

std::vector<RecordedPoint> numbered(std::uint64_t count) {
    std::vector<RecordedPoint> points(count);
    for (std::uint64_t i = 0; i < count; ++i)
        points[i].sequence = i + 1;
    return points;
}

TEST(OperatorChoice, NumbersAndRanges) {
    auto choice = OperatorChoice::parse({"2,5-7", "9"}, {"3"});
    ASSERT_TRUE(choice) << choice.error().message;
    auto points = numbered(10);
    points[2].verdict.reason = RejectReason::no_contact;
    choice->apply(points);
    for (const RecordedPoint& point : points) {
        const auto s = point.sequence;
        const bool rejected = s == 2 || (s >= 5 && s <= 7) || s == 9;
        EXPECT_EQ(point.verdict.reason, rejected ? RejectReason::by_operator : RejectReason::none) << s;
        EXPECT_EQ(point.verdict.kept, s == 3) << s;
    }
    EXPECT_TRUE(choice->all_found());
}

TEST(OperatorChoice, WrongOnesAreRefused) {
    for (const char* wrong : {"", "x", "3-", "-3", "7-5", "1,,2", "1.5", "1-99999999999", "99999999999999999999"})
        EXPECT_FALSE(OperatorChoice::parse({wrong}, {})) << wrong;
    EXPECT_FALSE(OperatorChoice::parse({"1-5"}, {"3"})) << "both";
    auto choice = OperatorChoice::parse({"4", "40"}, {});
    ASSERT_TRUE(choice);
    auto points = numbered(10);
    choice->apply(points);
    const auto status = choice->all_found();
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, core::ErrorCode::usage);
    EXPECT_NE(status.error().message.find("40"), std::string::npos);
}

}  // namespace
}  // namespace cmm::acquisition
