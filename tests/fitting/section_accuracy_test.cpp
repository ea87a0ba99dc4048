// SPDX-License-Identifier: Apache-2.0
/// The promises of the section method against exact truth, over blades, balls, densities and seeds.
#include <gtest/gtest.h>

#include <iostream>

#include "fitting/section.hpp"
#include "fitting/vec2.hpp"
#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

struct Tally {
    double side = 0.0, edge = 0.0;  // largest deviations
    std::size_t clear_bad = 0, missed = 0, good = 0, good_rejected = 0, sections = 0;

    void add(const truth::Outline& part, const truth::Scan& scan, const SectionFit& fit, std::size_t stride) {
        ++sections;
        for (std::size_t i = 0; i < scan.points.size(); ++i) {
            const bool rejected = fit.verdicts[i].reason != RejectReason::none;
            if (std::abs(scan.bad[i]) > 0.040) {
                ++clear_bad;
                missed += !rejected;
            } else if (scan.bad[i] == 0.0) {
                ++good;
                good_rejected += rejected;
            }
        }
        for (std::size_t i = 0; i < fit.contour.size(); i += stride) {
            const ContourPoint& p = fit.contour[i];
            double& worst = p.zone == Zone::le || p.zone == Zone::te ? edge : side;
            worst = std::max(worst, std::abs(part.distance(p.position_mm)));
        }
    }
    double good_rejected_percent() const {
        return 100.0 * static_cast<double>(good_rejected) / static_cast<double>(good);
    }
    void print(const std::string& what) const {
        std::cout << what << ": " << sections << " sections, sides " << 1e3 * side << " um, edges " << 1e3 * edge
                  << " um, missed " << missed << " of " << clear_bad << ", good rejected " << good_rejected_percent()
                  << " %\n";
    }
};

void run(const truth::Outline& part, double ball, truth::ScanOptions scanning, int seeds, Tally& tally,
         std::size_t stride = 11) {
    const auto centres = truth::ball_centres(part, ball);
    SectionOptions options;
    options.ball_radius_mm = ball;
    for (int k = 0; k < seeds; ++k) {
        scanning.seed = 5000 + k;
        scanning.start_share = 0.37 * k - std::floor(0.37 * k);
        scanning.clockwise = k % 2 == 1;
        scanning.overlap_mm = k % 3 == 0 ? 2.0 : 0.0;
        const auto scan = truth::scan(centres, scanning);
        const auto fit = fit_section(scan.points, {}, options);
        ASSERT_TRUE(fit) << part.name << " ball " << ball << " seed " << k << ": " << fit.error().message;
        tally.add(part, scan, *fit, stride);
    }
}

std::vector<truth::Outline> smooth_blades() {
    std::vector<truth::Outline> blades{truth::envelope_blade({}), truth::envelope_blade({55, 3.0, 20, 50, 0.15, 0.12}),
                                       truth::envelope_blade({35, 6, 75, 30, 2.0, 0.4}),
                                       truth::ellipse_edged_blade(50, 25, 1.2, 0.4, 0.8, 0.25, 3.0),
                                       truth::naca_blade(45, 0.08, 0.05)};
    return blades;
}

TEST(SectionAccuracy, WithoutNoise) {
    truth::ScanOptions scanning;
    scanning.noise = 0.0;
    scanning.bad_share = 0.0;
    scanning.pitch = 0.1;
    scanning.edge_density = 4.0;
    Tally tally;
    for (const auto& blade : smooth_blades())
        run(blade, 1.0, scanning, 2, tally);
    tally.print("noise-free, 0.1 mm");
    EXPECT_LT(tally.side, 0.002);
    EXPECT_LT(tally.edge, 0.002);
    EXPECT_EQ(tally.good_rejected, 0U);
}

TEST(SectionAccuracy, DenseScansOfSmoothBlades) {
    truth::ScanOptions scanning;
    scanning.pitch = 0.08;
    scanning.edge_density = 2.0;
    Tally tally;
    for (const auto& blade : smooth_blades())
        for (const double ball : {0.25, 1.0, 3.0})
            run(blade, ball, scanning, 8, tally);
    tally.print("dense");
    EXPECT_LT(tally.side, 0.030);
    EXPECT_LT(tally.edge, 0.030);
    EXPECT_EQ(tally.missed, 0U) << "of " << tally.clear_bad;
    EXPECT_LE(tally.good_rejected_percent(), 0.2);
}

TEST(SectionAccuracy, ScansAtThePitchOfAPlan) {
    Tally tally;
    for (const auto& blade : smooth_blades())
        for (const double ball : {0.5, 1.0, 2.0})
            run(blade, ball, {}, 10, tally);
    tally.print("0.4 mm, edges 0.1 mm");
    EXPECT_EQ(tally.missed, 0U) << "of " << tally.clear_bad;
    EXPECT_LE(tally.good_rejected_percent(), 0.2);
    EXPECT_LT(tally.edge, 0.030);
    EXPECT_LT(tally.side, 0.030);
}

TEST(SectionAccuracy, RealCompressorBlades) {
    auto outlines = truth::rotor37_outlines();
    const auto hannover = truth::hannover_outlines();
    if (outlines.empty() || hannover.empty()) GTEST_SKIP() << "../shared/data/rotor37 or hannover-4ac is absent";
    for (std::size_t k = 0; k < hannover.size(); k += 3)
        outlines.push_back(hannover[k]);
    truth::ScanOptions scanning;
    scanning.pitch = 0.16;
    Tally tally;
    for (const auto& outline : outlines)
        run(outline, 1.0, scanning, 6, tally, 23);
    tally.print("rotor37 and hannover-4ac");
    EXPECT_EQ(tally.missed, 0U) << "of " << tally.clear_bad;
    EXPECT_LE(tally.good_rejected_percent(), 0.2);
    EXPECT_LT(tally.edge, 0.030);
    EXPECT_LT(tally.side, 0.030);
}

/// Facets, texture of some micrometres and a concave corner that a 1 mm ball cannot enter: there the truth is the part
/// that the ball can touch, the parallel curve of the true ball centres.
TEST(SectionAccuracy, EngineBladeWithTextureAndACorner) {
    const auto outlines = truth::engine_outlines();
    if (outlines.empty()) GTEST_SKIP() << "../shared/data/engine-blade is absent";
    truth::ScanOptions scanning;
    scanning.pitch = 0.1;
    scanning.edge_density = 2.0;
    Tally tally;
    double reachable = 0.0;
    for (const auto& part : outlines) {
        const auto centres = truth::ball_centres(part, 1.0);
        for (int k = 0; k < 4; ++k) {
            scanning.seed = 300 + k;
            scanning.start_share = 0.3 * k;
            scanning.clockwise = k % 2 == 1;
            const auto scan = truth::scan(centres, scanning);
            const auto fit = fit_section(scan.points, {}, {});
            ASSERT_TRUE(fit) << part.name << ": " << fit.error().message;
            tally.add(part, scan, *fit, 11);
            for (std::size_t i = 0; i < fit->contour.size(); i += 11) {
                const Vec2& p = fit->contour[i].position_mm;
                reachable =
                    std::max(reachable, std::min(std::abs(part.distance(p)), std::abs(centres.distance(p) + 1.0)));
            }
        }
    }
    tally.print("engine blade");
    std::cout << "engine blade, from what the ball reaches: " << 1e3 * reachable << " um\n";
    EXPECT_EQ(tally.missed, 0U) << "of " << tally.clear_bad;
    EXPECT_LE(tally.good_rejected_percent(), 0.2);
    EXPECT_LT(tally.edge, 0.030);
    EXPECT_LT(reachable, 0.035) << "in the corner, which a C2 curve rounds; elsewhere below 0.012";
}

}  // namespace
}  // namespace cmm::fitting
