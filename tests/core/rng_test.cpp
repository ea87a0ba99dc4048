// SPDX-License-Identifier: Apache-2.0
#include "core/rng.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cmm::core {
namespace {

TEST(Rng, FollowsThePublishedSplitmix64) {
    // Reference output for seed 1234567 as printed with the authors' C code (xoshiro.di.unimi.it/splitmix64.c).
    Rng rng(1234567);
    EXPECT_EQ(rng.next(), 6457827717110365317ULL);
    EXPECT_EQ(rng.next(), 3203168211198807973ULL);
    EXPECT_EQ(rng.next(), 9817491932198370423ULL);
}

TEST(Rng, NormalHasItsMoments) {
    Rng rng(42);
    double sum = 0.0;
    double squares = 0.0;
    double fourth = 0.0;
    constexpr int n = 200'000;
    for (int i = 0; i < n; ++i) {
        const double x = rng.normal();
        ASSERT_TRUE(std::isfinite(x));
        sum += x;
        squares += x * x;
        fourth += x * x * x * x;
    }
    EXPECT_NEAR(sum / n, 0.0, 0.01);
    EXPECT_NEAR(squares / n, 1.0, 0.015);
    EXPECT_NEAR(fourth / n, 3.0, 0.1);
}

TEST(Rng, KeyedStreamsDependOnEveryKeyAndOnNothingElse) {
    const auto first = [](std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
        return Rng::keyed(seed, stream, index).next();
    };
    EXPECT_EQ(first(1, 2, 3), first(1, 2, 3));
    EXPECT_NE(first(1, 2, 3), first(2, 2, 3));
    EXPECT_NE(first(1, 2, 3), first(1, 3, 3));
    EXPECT_NE(first(1, 2, 3), first(1, 2, 4));
    EXPECT_NE(first(1, 2, 3), first(1, 3, 2));
}

TEST(Rng, UniformStaysInItsRange) {
    Rng rng(7);
    for (int i = 0; i < 10'000; ++i) {
        const double x = rng.uniform(-2.0, 3.0);
        ASSERT_GE(x, -2.0);
        ASSERT_LT(x, 3.0);
        ASSERT_LT(rng.below(5), 5U);
    }
}

}  // namespace
}  // namespace cmm::core
