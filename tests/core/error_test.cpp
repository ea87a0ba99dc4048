// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"

#include <gtest/gtest.h>

#include <set>

namespace cmm::core {
namespace {

constexpr int last_code = static_cast<int>(ErrorCode::internal);

TEST(Error, EveryCodeHasItsOwnNameAdviceAndContractExitCode) {
    const std::set<int> contract{3, 4, 5, 6, 70};
    std::set<std::string_view> names;
    for (int i = 0; i <= last_code; ++i) {
        const auto code = static_cast<ErrorCode>(i);
        EXPECT_TRUE(names.insert(to_string(code)).second) << to_string(code);
        EXPECT_GE(advice(code).size(), 20U) << to_string(code);
        EXPECT_TRUE(contract.contains(exit_code(code))) << to_string(code);
    }
}

TEST(Error, OnlyTheLinkIsRetried) {
    for (int i = 0; i <= last_code; ++i) {
        const auto code = static_cast<ErrorCode>(i);
        if (retryable(code)) {
            EXPECT_EQ(exit_code(code), 5) << to_string(code);
        }
    }
}

TEST(Error, CarriesItsContextInnermostFirst) {
    auto error =
        Error{ErrorCode::machine_fault, "axis lag", {}, Motion::stopped}.with_context("path 4").with_context("run 7");
    EXPECT_EQ(error.text(), "axis lag (path 4) (run 7)");
    EXPECT_EQ(to_string(error.motion), "stopped");
}

TEST(Error, FailMakesAResult) {
    const Result<int> result = fail(ErrorCode::journal_full, "disk", Motion::unknown);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::journal_full);
    EXPECT_EQ(result.error().motion, Motion::unknown);
}

}  // namespace
}  // namespace cmm::core
