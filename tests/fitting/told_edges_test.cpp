// SPDX-License-Identifier: Apache-2.0
/// Edge models of a section whose other sections know its curve, or do not.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "fitting/centre_curve.hpp"
#include "fitting/contour.hpp"
#include "support/natural_blade.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t told_stations = 40;

/// Whether the contour takes a model of the LE when stations say that this share of the curve's noise is left.
bool takes_model(const CentreCurve& centres, const SectionOptions& options, std::optional<double> noise_share) {
    std::vector<SurfaceStation> stations;
    for (std::size_t k = 0; noise_share && k < told_stations; ++k) {
        stations.emplace_back().t = centres.smooth.curve.period() * double(k) / double(told_stations);
        stations.back().noise_share = *noise_share;
    }
    SectionFit fit;
    const auto open = build_contour(centres.smooth, centres.good, options, fit, stations);
    EXPECT_TRUE(open) << open.error().message;
    return fit.le.used_in_contour;
}

/// Noses without any of the models, whose few points bear one that is more than four sigmas off their own curve.
TEST(ToldEdges, AModelIsRefusedByWhatOtherSectionsToldAlone) {
    const std::vector<std::pair<std::uint64_t, std::uint64_t>> blades_and_scans{{3, 309}, {7, 707}, {8, 815}};
    for (const auto& [seed, scan] : blades_and_scans) {
        const natural::Blade blade(seed, true);
        SectionOptions options;
        options.ball_radius_mm = 1.0;
        options.le_hint = blade.le();
        options.te_hint = blade.te();
        const auto centres = fit_centre_curve(blade.scan(scan, options.ball_radius_mm, 1.0).centres, {}, options);
        ASSERT_TRUE(centres) << centres.error().message;
        EXPECT_TRUE(takes_model(*centres, options, {})) << seed;
        EXPECT_TRUE(takes_model(*centres, options, 1.0)) << seed;
        EXPECT_FALSE(takes_model(*centres, options, 0.3)) << seed;
    }
}

}  // namespace
}  // namespace cmm::fitting
