// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <limits>
#include <new>
#include <utility>

#include "core/rng.hpp"
#include "fitting/live_spline.hpp"
#include "support/families.hpp"

namespace {

std::atomic<std::size_t> allocations{0};

void* counted(std::size_t size, const std::nothrow_t&) noexcept {
    ++allocations;
    return std::malloc(size > 0 ? size : 1);
}

void* counted(std::size_t size) {
    if (void* memory = counted(size, std::nothrow)) return memory;
    throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) {
    return counted(size);
}
void* operator new[](std::size_t size) {
    return counted(size);
}
void* operator new(std::size_t size, const std::nothrow_t& none) noexcept {
    return counted(size, none);
}
void* operator new[](std::size_t size, const std::nothrow_t& none) noexcept {
    return counted(size, none);
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete[](void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
    std::free(memory);
}

namespace cmm::fitting {
namespace {

using Taken = LiveSpline::Taken;

/// With bad points, edges and noise.
std::vector<Vec2> blade_scan(std::uint64_t seed) {
    families::ScanOptions options;
    options.seed = seed;
    return families::scan(families::make(families::Family::turbine, seed), options).points;
}

/// Bit for bit.
void expect_equal(const LiveSpline& a, const LiveSpline& b, std::size_t at) {
    for (std::size_t back = 0; back <= LiveSpline::lag; ++back) {
        const auto p = a.point(back), q = b.point(back);
        ASSERT_EQ(p.valid, q.valid) << at;
        ASSERT_EQ(p.sequence, q.sequence) << at;
        ASSERT_EQ(p.doubtful, q.doubtful) << at;
        ASSERT_EQ(p.position, q.position) << at;
        ASSERT_EQ(p.tangent, q.tangent) << at;
        ASSERT_EQ(p.curvature, q.curvature) << at;
        ASSERT_EQ(p.sigma_mm, q.sigma_mm) << at;
    }
    ASSERT_EQ(a.predict(0.2).centre, b.predict(0.2).centre) << at;
    ASSERT_EQ(a.predict(0.2).sigma_mm, b.predict(0.2).sigma_mm) << at;
    ASSERT_EQ(a.noise_mm(), b.noise_mm()) << at;
    ASSERT_EQ(a.length_mm(), b.length_mm()) << at;
    ASSERT_EQ(a.turned_rad(), b.turned_rad()) << at;
    ASSERT_EQ(a.closed(), b.closed()) << at;
}

TEST(LiveOrder, AScanThatIsTakenUpAgainGoesOnAsIfNothingHadHappened) {
    const auto scan = blade_scan(4);
    LiveSpline whole(MaterialSide::left), broken(MaterialSide::left);
    for (std::size_t i = 0; i < scan.size(); ++i) {
        whole.add(i, scan[i]);
        if (i % 97 == 50) {
            broken = LiveSpline(MaterialSide::left);
            for (std::size_t k = 0; k < i; ++k)
                broken.add(k, scan[k]);
        }
        broken.add(i, scan[i]);
        expect_equal(whole, broken, i);
    }
}

TEST(LiveOrder, LateSamplesGiveTheSameBits) {
    const auto scan = blade_scan(5);
    core::Rng rng(9);
    LiveSpline ordered(MaterialSide::left), shuffled(MaterialSide::left);
    std::size_t first = 0, late = 0;
    while (first < scan.size()) {
        const auto wanted = 1 + static_cast<std::size_t>(static_cast<double>(LiveSpline::depth) * rng.uniform());
        std::vector<std::size_t> block(std::min(wanted, scan.size() - first));
        for (std::size_t k = 0; k < block.size(); ++k)
            block[k] = first + k;
        for (std::size_t k = block.size(); k > 1; --k)
            std::swap(block[k - 1], block[static_cast<std::size_t>(static_cast<double>(k) * rng.uniform())]);
        for (const std::size_t i : block) {
            const auto taken = shuffled.add(i, scan[i]);
            ASSERT_TRUE(taken == Taken::newest || taken == Taken::late);
            late += taken == Taken::late;
        }
        for (std::size_t k = 0; k < block.size(); ++k)
            EXPECT_EQ(ordered.add(first + k, scan[first + k]), Taken::newest);
        first += block.size();
        expect_equal(ordered, shuffled, first);
    }
    EXPECT_GT(late, scan.size() / 4);
}

TEST(LiveOrder, RepeatedAndStaleSamplesChangeNothing) {
    const auto scan = blade_scan(6);
    LiveSpline once(MaterialSide::left), often(MaterialSide::left);
    for (std::size_t i = 0; i < scan.size(); ++i) {
        once.add(10 * i, scan[i]);
        EXPECT_EQ(often.add(10 * i, scan[i]), Taken::newest);
        EXPECT_EQ(often.add(10 * i, {0.0, 0.0}), Taken::repeated);
        expect_equal(once, often, i);
        if (i < 40) continue;
        EXPECT_EQ(often.add(10 * (i - 5), scan[i - 5]), Taken::repeated);
        EXPECT_EQ(often.add(10 * (i - 40), scan[i - 40]), Taken::stale);
        EXPECT_EQ(often.add(10 * (i - 40) + 3, {0.0, 0.0}), Taken::stale);
        expect_equal(once, often, i);
    }
}

TEST(LiveOrder, WhatDoesNotCountKeepsItsPlaceOnly) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const auto scan = blade_scan(7);
    LiveSpline curve(MaterialSide::left);
    curve.add(0, scan[0]);
    curve.add(1, scan[0]);
    curve.add(2, {std::nan(""), 1.0});
    curve.add(3, {inf, 1.0});
    EXPECT_FALSE(curve.newest().valid);
    EXPECT_FALSE(curve.predict(0.1).valid);
    EXPECT_FALSE(curve.closed());
    EXPECT_EQ(curve.length_mm(), 0.0);
    std::uint64_t sequence = 10;
    for (std::size_t i = 1; i < 60; ++i) {
        curve.add(++sequence, scan[i]);
        if (!curve.newest().valid) continue;
        const auto before = curve.predict(0.1);
        curve.add(++sequence, scan[i]);
        curve.add(++sequence, scan[i] + Vec2(0.3, 0.3), true);
        EXPECT_EQ(curve.newest().sequence, sequence);
        EXPECT_FALSE(curve.newest().doubtful);
        EXPECT_TRUE(curve.newest().skipped);
        EXPECT_EQ(curve.predict(0.1).centre, before.centre);
    }
}

TEST(LiveOrder, AddAllocatesNothing) {
    const auto scan = blade_scan(8);
    LiveSpline curve(MaterialSide::left);
    double sum = 0.0;
    const std::size_t before = allocations;
    for (std::uint64_t i = 0; i < 50'000; ++i) {
        curve.add(i ^ 1U, scan[(i ^ 1U) % scan.size()]);  // every second one late
        sum += curve.newest().curvature + curve.predict(0.1).sigma_mm + curve.suggest_step(0.1, 0.4, 1e-3);
    }
    EXPECT_EQ(allocations, before);
    EXPECT_TRUE(std::isfinite(sum));
    EXPECT_NE(std::vector<int>(3).data(), nullptr);
    EXPECT_GT(allocations, before) << "the count counts";
}

}  // namespace
}  // namespace cmm::fitting
