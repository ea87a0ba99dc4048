// SPDX-License-Identifier: Apache-2.0
#include "fitting/group_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

using Eigen::Vector3d;

/// A grid in any order: each eight are a block of two by two by two, and each eight of these a block of four.
TEST(GroupOrder, NeighboursShareTheirGroupsAtEveryLevel) {
    std::vector<Vector3d> places;
    for (int k = 0; k < 512; ++k)
        places.emplace_back(k % 8, k / 8 % 8, k / 64);
    core::Rng rng(1);
    for (std::size_t k = places.size(); k-- > 1;)
        std::swap(places[k], places[rng.below(k + 1)]);
    const auto order = order_in_groups(places, 8);
    ASSERT_EQ(order.size(), places.size());
    for (const auto& [group, extent] : {std::pair{8U, 1.0}, {64U, 3.0}, {512U, 7.0}})
        for (std::size_t first = 0; first < order.size(); first += group) {
            Vector3d low = places[order[first]], high = low;
            for (std::size_t k = first; k < first + group; ++k) {
                low = low.cwiseMin(places[order[k]]);
                high = high.cwiseMax(places[order[k]]);
            }
            EXPECT_EQ((high - low).maxCoeff(), extent) << first;
        }
}

TEST(GroupOrder, HasEachPlaceOnce) {
    core::Rng rng(2);
    for (const std::size_t count : {0U, 1U, 2U, 7U, 8U, 9U, 63U, 65U, 1000U}) {
        std::vector<Vector3d> places;
        for (std::size_t k = 0; k < count; ++k)
            places.emplace_back(rng.uniform(0, 1), k % 3 == 0 ? 0.0 : rng.uniform(0, 1), 0.0);
        auto order = order_in_groups(places, 8);
        std::sort(order.begin(), order.end());
        ASSERT_EQ(order.size(), count);
        for (std::size_t k = 0; k < count; ++k)
            EXPECT_EQ(order[k], k);
    }
}

}  // namespace
}  // namespace cmm::fitting
