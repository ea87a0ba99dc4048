// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "fitting/section.hpp"
#include "support/families.hpp"

namespace cmm::fitting {
namespace {

std::vector<double> numbers_of(const SectionFit& fit) {
    std::vector<double> all{fit.chord_mm, fit.noise_sigma_mm, fit.le.radius_mm, fit.te.radius_mm, fit.le.radius_u95_mm};
    for (const ContourPoint& point : fit.contour)
        all.insert(all.end(), {point.position_mm.x(), point.position_mm.y(), point.normal.x(), point.normal.y(),
                               point.u95_mm, point.flattened_mm});
    for (const PointVerdict& verdict : fit.verdicts)
        all.insert(all.end(), {verdict.residual_mm, static_cast<double>(verdict.reason)});
    return all;
}

/// What the contour does not need is left for later: it stays as it is to the last bit.
TEST(SectionSteps, EdgesThatTheContourDoesNotNeedAreMadeAfterIt) {
    for (const auto family : families::all_families) {
        const auto scan = families::scan(families::make(family, 1), {.points = 2000, .seed = 1}).points;
        auto fit = fit_contour(scan, {}, {});
        ASSERT_TRUE(fit) << fit.error().text();
        ASSERT_TRUE(fit->open_edges);
        EXPECT_EQ(fit->le.radius_mm, 0.0);
        EXPECT_EQ(fit->te.radius_mm, 0.0);
        const auto contour = fit->contour;
        fit_edges(*fit);
        EXPECT_FALSE(fit->open_edges);
        EXPECT_TRUE(fit->le.valid) << fit->le.why;
        EXPECT_TRUE(fit->te.valid) << fit->te.why;
        EXPECT_FALSE(fit->le.used_in_contour || fit->te.used_in_contour);
        for (std::size_t i = 0; i < contour.size(); ++i)
            ASSERT_EQ(contour[i].position_mm, fit->contour[i].position_mm);
        const auto whole = fit_section(scan, {}, {});
        ASSERT_TRUE(whole);
        EXPECT_EQ(numbers_of(*whole), numbers_of(*fit));
    }
}

/// The same sections fitted one after the other, again, and by two threads at once: equal to the last bit.
TEST(SectionThreads, FitsAreTheSameFromRunToRunAndBesideOthers) {
    std::vector<std::vector<Eigen::Vector2d>> scans;
    for (const auto family : families::all_families)
        for (std::uint64_t seed = 1; seed <= 3; ++seed)
            scans.push_back(families::scan(families::make(family, seed), {.points = 600, .seed = seed}).points);
    using Results = std::vector<std::vector<double>>;
    const auto fit_all = [&scans](Results& out) {
        for (const auto& points : scans) {
            const auto fit = fit_section(points, {}, {});
            out.push_back(fit ? numbers_of(*fit) : std::vector<double>());
        }
    };
    Results once, again, one, other;
    fit_all(once);
    fit_all(again);
    std::thread beside([&] { fit_all(one); });
    fit_all(other);
    beside.join();
    for (std::size_t k = 0; k < scans.size(); ++k) {
        EXPECT_GT(once[k].size(), 10000U) << k;
        EXPECT_EQ(once[k], again[k]) << k;
        EXPECT_EQ(once[k], one[k]) << k;
        EXPECT_EQ(once[k], other[k]) << k;
    }
}

}  // namespace
}  // namespace cmm::fitting
