// SPDX-License-Identifier: Apache-2.0
#include "acquisition/gauge_anova.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "core/rng.hpp"
#include "tests/acquisition/gauge_example.hpp"

namespace cmm::acquisition {
namespace {

/// The published table of variance and what AIAG makes of it (4th edition, tables A 3 to A 5 and III-B 8).
TEST(GaugeAnova, GivesThePublishedNumbers) {
    const auto found = analyse_gauge(aiag_values());
    EXPECT_NEAR(found.appraisers.squares, 3.1673, 5e-5);
    EXPECT_NEAR(found.parts.squares, 88.3619, 5e-5);
    EXPECT_NEAR(found.interaction.squares, 0.3590, 5e-5);
    EXPECT_NEAR(found.repeats.squares, 2.7589, 5e-5);
    EXPECT_EQ(found.appraisers.freedom, 2.0);
    EXPECT_EQ(found.parts.freedom, 9.0);
    EXPECT_EQ(found.interaction.freedom, 18.0);
    EXPECT_EQ(found.repeats.freedom, 60.0);
    EXPECT_NEAR(found.interaction.mean() / found.repeats.mean(), 0.434, 5e-4);
    EXPECT_NEAR(found.interaction_p.value(), 0.974, 5e-4);
    EXPECT_TRUE(found.pooled);
    EXPECT_NEAR(found.repeatability.deviation, 0.199933, 5e-7);
    EXPECT_NEAR(found.reproducibility->deviation, 0.226838, 5e-7);
    EXPECT_FALSE(found.interacting);
    EXPECT_NEAR(found.gauge.deviation, 0.302373, 2e-6) << "published: the root of rounded variances";
    EXPECT_NEAR(found.part_variation->deviation, 1.042327, 5e-7);
    EXPECT_NEAR(found.share_of_total().value(), 0.279, 5e-4);
    EXPECT_EQ(found.categories().value(), 4.0);
    EXPECT_EQ(found.share_of_tolerance(6.0), found.gauge.deviation);
    // 78 degrees of freedom: chi-square 55.466 and 104.316 (tables), 3.1179 the sum of squares.
    EXPECT_NEAR(found.repeatability.low, std::sqrt(3.1179 / 104.316), 2e-5);
    EXPECT_NEAR(found.repeatability.high, std::sqrt(3.1179 / 55.466), 2e-5);
}

struct Truth {
    double repeats, appraisers, interaction, parts;
};

GaugeValues drawn(core::Rng& rng, const Truth& truth, std::size_t parts, std::size_t appraisers, std::size_t trials) {
    GaugeValues values(parts, appraisers, trials);
    std::vector<double> of_appraiser;
    for (std::size_t j = 0; j < appraisers; ++j)
        of_appraiser.push_back(truth.appraisers * rng.normal());
    for (std::size_t i = 0; i < parts; ++i) {
        const double of_part = truth.parts * rng.normal();
        for (std::size_t j = 0; j < appraisers; ++j) {
            const double both = truth.interaction * rng.normal();
            for (std::size_t k = 0; k < trials; ++k)
                values.at(i, j, k) = of_part + of_appraiser[j] + both + truth.repeats * rng.normal();
        }
    }
    return values;
}

/// How often the intervals hold the truth; without an interaction the pooled design, with a large one the other.
struct Coverage {
    double repeatability = 0.0, reproducibility = 0.0, gauge = 0.0, parts = 0.0, total = 0.0;
};

Coverage coverage_of(const Truth& truth, std::size_t parts, std::size_t appraisers, std::size_t trials) {
    core::Rng rng(4711);
    constexpr int studies = 4000;
    Coverage held;
    const auto count = [](double& share, const std::optional<GaugeComponent>& said, double variance) {
        const double is = std::sqrt(variance);
        if (said && said->low <= is && is <= said->high) share += 1.0 / studies;
    };
    const auto square = [](double value) { return value * value; };
    for (int n = 0; n < studies; ++n) {
        const auto found = analyse_gauge(drawn(rng, truth, parts, appraisers, trials));
        const double e = square(truth.repeats), a = square(truth.appraisers), i = square(truth.interaction);
        count(held.repeatability, found.repeatability, e);
        count(held.reproducibility, found.reproducibility, a);
        count(held.gauge, found.gauge, e + (appraisers > 1 ? a + i : 0.0));
        count(held.parts, found.part_variation, square(truth.parts));
        count(held.total, found.total, e + a + i + square(truth.parts));
    }
    return held;
}

TEST(GaugeAnova, IntervalsHoldTheTruth) {
    const auto plain = coverage_of({1.0, 0.8, 0.0, 4.0}, 10, 3, 3);
    EXPECT_GT(plain.repeatability, 0.93);
    EXPECT_LT(plain.repeatability, 0.97);
    for (const double share : {plain.reproducibility, plain.gauge, plain.parts, plain.total}) {
        EXPECT_GT(share, 0.93);
        EXPECT_LT(share, 0.985) << "wide, but not idle";
    }
    const auto mixed = coverage_of({1.0, 1.5, 2.0, 4.0}, 8, 4, 2);
    for (const double share : {mixed.repeatability, mixed.reproducibility, mixed.gauge, mixed.parts, mixed.total}) {
        EXPECT_GT(share, 0.93);
        EXPECT_LT(share, 0.985);
    }
    const auto alone = coverage_of({1.0, 0.0, 0.0, 4.0}, 6, 1, 4);
    for (const double share : {alone.repeatability, alone.gauge, alone.parts, alone.total}) {
        EXPECT_GT(share, 0.93);
        EXPECT_LT(share, 0.985);
    }
}

TEST(GaugeAnova, AnInteractionThatShowsStandsForItself) {
    core::Rng rng(5);
    const auto found = analyse_gauge(drawn(rng, {0.1, 0.2, 1.0, 3.0}, 12, 5, 3));
    EXPECT_FALSE(found.pooled);
    EXPECT_LT(found.interaction_p.value(), 0.01);
    ASSERT_TRUE(found.interacting);
    EXPECT_LT(found.interacting->low, 1.0);
    EXPECT_GT(found.interacting->high, 1.0);
    EXPECT_NEAR(found.repeatability.deviation, 0.1, 0.03);
    EXPECT_NEAR(
        std::hypot(found.repeatability.deviation, found.interacting->deviation, found.reproducibility->deviation),
        found.gauge.deviation, 1e-12);
}

TEST(GaugeAnova, SaysOnlyWhatOneAppraiserOrOnePartTells) {
    core::Rng rng(6);
    const auto alone = analyse_gauge(drawn(rng, {0.5, 9.0, 0.0, 2.0}, 10, 1, 4));
    EXPECT_FALSE(alone.reproducibility);
    EXPECT_FALSE(alone.interaction_p);
    EXPECT_EQ(alone.gauge.deviation, alone.repeatability.deviation);
    EXPECT_NEAR(alone.repeatability.deviation, 0.5, 0.15);
    EXPECT_TRUE(alone.part_variation && alone.categories());
    const auto one_part = analyse_gauge(drawn(rng, {0.5, 2.0, 0.0, 9.0}, 1, 6, 5));
    EXPECT_TRUE(one_part.reproducibility);
    EXPECT_FALSE(one_part.part_variation || one_part.total || one_part.share_of_total() || one_part.categories());
    const auto single = analyse_gauge(drawn(rng, {0.5, 2.0, 0.0, 9.0}, 1, 1, 30));
    EXPECT_EQ(single.gauge.deviation, single.repeatability.deviation);
    EXPECT_EQ(single.repeats.freedom, 29.0);
}

TEST(GaugeAnova, EqualValuesVaryByNothing) {
    const auto same = analyse_gauge(GaugeValues(3, 2, 2));
    EXPECT_TRUE(same.pooled);
    EXPECT_EQ(same.gauge.deviation, 0.0);
    EXPECT_FALSE(same.share_of_total());
    EXPECT_FALSE(same.categories());
}

}  // namespace
}  // namespace cmm::acquisition
