// SPDX-License-Identifier: Apache-2.0
#include "fitting/row_alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <random>
#include <utility>
#include <vector>

namespace cmm::fitting {
namespace {

/// Rows of 100 mm with edges of 3 and 2 mm.
std::vector<RowFeatures> alike(std::size_t count) {
    std::vector<RowFeatures> rows(count);
    for (std::size_t k = 0; k < count; ++k) {
        rows[k].z_mm = 10.0 * static_cast<double>(k);
        rows[k].length_mm = 100.0;
        rows[k].s_mm = {0.0, 3.0, 48.0, 50.0, 52.0, 97.0};
    }
    return rows;
}

/// Four rows whose joints come nearer and nearer to the nose put the fifth's behind it.
TEST(RowAlignment, PlacesFollowEachOtherOnEveryRow) {
    std::vector<RowFeatures> rows = alike(5);
    for (std::size_t k = 0; k < 4; ++k)
        rows[k].joints[RowFeatures::te_begin] = RowJoint{48.0 + 0.6 * static_cast<double>(k), 0.01, 0.5};
    const RowAlignment alignment(rows);
    EXPECT_EQ(alignment.joints().size(), 1U);
    for (std::size_t k = 0; k < rows.size(); ++k)
        for (int i = 0; i < 1000; ++i)
            EXPECT_LT(alignment.arc_length(k, alignment.period() * i / 1000),
                      alignment.arc_length(k, alignment.period() * (i + 1) / 1000))
                << "row " << k << ", place " << i;
}

/// An LE that is longer from row to row: what is half-way along the sides stays there but for what the sides
/// are shorter (a smooth map through the features alone had it off by 1 mm).
TEST(RowAlignment, TheMiddlesOfSidesDoNotFollowTheEdges) {
    std::vector<RowFeatures> rows = alike(4);
    for (std::size_t k = 0; k < rows.size(); ++k) {
        rows[k].s_mm[RowFeatures::le_end] = 2.0 + static_cast<double>(k);
        rows[k].s_mm[RowFeatures::le_begin] = 98.0 - static_cast<double>(k);
    }
    const RowAlignment alignment(rows);
    for (std::size_t k = 0; k < rows.size(); ++k)
        for (const auto& [begins, ends] :
             {std::pair{RowFeatures::le_end, RowFeatures::te_begin}, {RowFeatures::te_end, RowFeatures::le_begin}}) {
            const double middle = 0.5 * (alignment.place(begins) + alignment.place(ends));
            EXPECT_NEAR(alignment.arc_length(k, middle), 0.5 * (rows[k].s_mm[begins] + rows[k].s_mm[ends]), 1e-9);
        }
}

/// All rows know a joint, each at a place of its own: it is none of the part, whose edges end evenly.
TEST(RowAlignment, JointsThatRowsDoNotAgreeOnAreNone) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    std::vector<RowFeatures> rows = alike(12);
    const auto knows = [&](double scatter_mm) {
        for (RowFeatures& row : rows)
            row.joints[RowFeatures::te_begin] = RowJoint{47.5 + scatter_mm * normal(random), 0.05, 0.5};
    };
    knows(0.05);
    EXPECT_EQ(RowAlignment(rows).joints().size(), 1U);
    knows(0.5);
    const RowAlignment apart(rows);
    EXPECT_TRUE(apart.joints().empty());
    for (std::size_t k = 0; k < rows.size(); ++k)
        EXPECT_NEAR(apart.arc_length(k, apart.place(RowFeatures::te_begin)), 48.0, 1e-9);
}

/// Of the part the curvature rises on all rows, or falls; one that steps the other way may be a bad point's.
TEST(RowAlignment, JointsThatStepBothWaysAreNone) {
    std::vector<RowFeatures> rows = alike(12);
    const auto joints_with = [&](std::size_t falling) {
        for (std::size_t k = 0; k < rows.size(); ++k)
            rows[k].joints[RowFeatures::te_begin] = RowJoint{47.5, 0.05, k < falling ? -0.5 : 0.5};
        return RowAlignment(rows).joints().size();
    };
    EXPECT_EQ(joints_with(0), 1U);
    EXPECT_EQ(joints_with(2), 1U);
    EXPECT_EQ(joints_with(4), 0U);
    EXPECT_EQ(joints_with(12), 1U);
}

/// A weak joint, which single rows hardly tell: where some do at one place, all have it, whatever others know
/// elsewhere.
TEST(RowAlignment, AFewRowsThatAgreeOnAJointTellItOfAll) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    const auto joints_with = [&](std::size_t agreeing, std::size_t strange, double scatter_mm) {
        std::vector<RowFeatures> rows = alike(25);
        for (std::size_t k = 0; k < agreeing + strange; ++k) {
            auto& joint = rows[(7 * k) % rows.size()].joints[RowFeatures::te_begin];
            if (k < agreeing)
                joint = RowJoint{47.0 + scatter_mm * normal(random), 0.05, 0.2 + 0.03 * normal(random)};
            else
                joint = RowJoint{48.5 + 0.4 * static_cast<double>(k - agreeing), 0.05, k % 2 == 0 ? 0.2 : -0.2};
        }
        const RowAlignment alignment(rows);
        if (!alignment.joints().empty()) {
            EXPECT_EQ(alignment.joints_on(24).size(), 1U);
            EXPECT_NEAR(alignment.joints_on(24).front().s_mm, 47.0, 0.1);
            EXPECT_NEAR(alignment.joints_on(24).front().step, 0.2, 0.04);
        }
        return alignment.joints().size();
    };
    EXPECT_EQ(joints_with(7, 0, 0.05), 1U);
    EXPECT_EQ(joints_with(7, 5, 0.05), 1U);
    EXPECT_EQ(joints_with(16, 8, 0.05), 1U);
    EXPECT_EQ(joints_with(3, 0, 0.05), 0U) << "by chance";
    EXPECT_EQ(joints_with(7, 0, 1.0), 0U) << "each at a place of its own";
}

}  // namespace
}  // namespace cmm::fitting
