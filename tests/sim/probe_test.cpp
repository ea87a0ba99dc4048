// SPDX-License-Identifier: Apache-2.0
#include "sim/probe.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

namespace cmm::sim {
namespace {

ProbeErrorModel model(double share) {
    ProbeErrorModel m;
    m.seed = 42;
    m.noise_mm = 0.001;
    m.bad_points_share = share;
    return m;
}

/// A path whose edges take a quarter of its points.
double edge_ness(std::uint32_t index) {
    return index % 400 < 100 ? 0.9 : 0.1;
}

constexpr std::uint32_t number = 400000;

TEST(ProbeError, DependsOnItsArgumentsAlone) {
    const auto m = model(0.05);
    std::vector<ProbeError> forward;
    for (std::uint32_t i = 0; i < 2000; ++i)
        forward.push_back(probe_error(m, 3, i, edge_ness(i)));
    int differing_seed = 0, differing_path = 0;
    for (std::uint32_t i = 2000; i-- > 0;) {
        const auto again = probe_error(m, 3, i, edge_ness(i));
        EXPECT_EQ(again.noise_mm, forward[i].noise_mm);
        EXPECT_EQ(again.bad_mm, forward[i].bad_mm);
        auto other = m;
        other.seed = 43;
        differing_seed += probe_error(other, 3, i, edge_ness(i)).noise_mm != forward[i].noise_mm;
        differing_path += probe_error(m, 4, i, edge_ness(i)).noise_mm != forward[i].noise_mm;
    }
    EXPECT_EQ(differing_seed, 2000);
    EXPECT_EQ(differing_path, 2000);
}

TEST(ProbeError, NoiseIsNormalWithTheGivenDeviation) {
    const auto m = model(0.0);
    double sum = 0.0, squares = 0.0, fourth = 0.0;
    for (std::uint32_t i = 0; i < number; ++i) {
        const auto error = probe_error(m, 1, i, 0.0);
        EXPECT_EQ(error.bad_mm, 0.0);
        const double n = error.noise_mm / m.noise_mm;
        sum += n;
        squares += n * n;
        fourth += n * n * n * n;
    }
    EXPECT_NEAR(sum / number, 0.0, 0.01);
    EXPECT_NEAR(squares / number, 1.0, 0.01);
    EXPECT_NEAR(fourth / number, 3.0, 0.06);
}

TEST(ProbeError, SharesSizesAndRunsComeOutAsAsked) {
    for (const double share : {0.01, 0.04}) {
        const auto m = model(share);
        double bad = 0.0, outward = 0.0, at_edges = 0.0, below_90_um = 0.0;
        std::map<int, int> runs;
        int run = 0;
        for (std::uint32_t i = 0; i < number; ++i) {
            const double mm = probe_error(m, 1, i, edge_ness(i)).bad_mm;
            if (mm == 0.0) {
                if (run > 0) ++runs[run];
                run = 0;
                continue;
            }
            ++run;
            bad += 1.0;
            outward += mm > 0.0;
            at_edges += edge_ness(i) > 0.5;
            below_90_um += std::abs(mm) < std::sqrt(0.020 * 0.400);
            EXPECT_GE(std::abs(mm), 0.020);
            EXPECT_LE(std::abs(mm), 0.400);
        }
        EXPECT_NEAR(bad / number, share, 0.05 * share);
        EXPECT_NEAR(outward / bad, 0.75, 0.03);
        EXPECT_NEAR(at_edges / bad, 0.70, 0.03);
        EXPECT_NEAR(below_90_um / bad, 0.5, 0.05);
        EXPECT_GT(runs[1], runs[2]);
        EXPECT_GT(runs[2], runs[3]);
        EXPECT_GT(runs[3], 0);
        EXPECT_EQ(runs.rbegin()->first, 3);
    }
}

TEST(ProbeError, ExtremeShares) {
    for (std::uint32_t i = 0; i < 1000; ++i) {
        EXPECT_NE(probe_error(model(1.0), 1, i, edge_ness(i)).bad_mm, 0.0);
    }
    double bad = 0.0;
    auto m = model(0.5);
    m.edge_points_share = 0.0;
    for (std::uint32_t i = 0; i < number; ++i)
        bad += probe_error(m, 1, i, 0.2).bad_mm != 0.0;
    EXPECT_NEAR(bad / number, 0.5, 0.01);
}

}  // namespace
}  // namespace cmm::sim
