// SPDX-License-Identifier: Apache-2.0
#include "fitting/filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "core/rng.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {
namespace {

using std::numbers::pi;
constexpr FilterKind all_kinds[] = {FilterKind::gaussian, FilterKind::spline, FilterKind::robust_gaussian};

/// Places of a profile of 40 mm, on average 0.04 mm apart, steps between a half and one and a half of that.
std::vector<double> places(std::uint64_t seed) {
    core::Rng rng(seed);
    std::vector<double> s;
    for (double x = 0.0; x < 40.0; x += 0.04 * rng.uniform(0.5, 1.5))
        s.push_back(x);
    return s;
}

std::vector<double> wave(const std::vector<double>& s, double length) {
    std::vector<double> z;
    for (const double x : s)
        z.push_back(std::sin(2.0 * pi * x / length));
    return z;
}

/// Height of the wave in a profile, over whole waves away from the ends, by projection with the samples' shares.
double height(const std::vector<double>& s, const std::vector<double>& z, double length) {
    double a = 0.0, b = 0.0, all = 0.0;
    for (std::size_t i = 1; i + 1 < s.size(); ++i) {
        if (s[i] < 8.0 || s[i] >= 8.0 + length * std::floor(24.0 / length)) continue;
        const double share = 0.5 * (s[i + 1] - s[i - 1]);
        a += share * z[i] * std::sin(2.0 * pi * s[i] / length);
        b += share * z[i] * std::cos(2.0 * pi * s[i] / length);
        all += share;
    }
    return 2.0 * std::hypot(a, b) / all;
}

double passed(FilterKind kind, double cutoff, double length) {
    const auto s = places(11);
    const auto filtered = filter_profile(s, wave(s, length), {kind, cutoff});
    EXPECT_TRUE(filtered) << filtered.error().message;
    return height(s, *filtered, length);
}

TEST(Filter, HalfOfTheCutOffWavelengthPasses) {
    for (const FilterKind kind : {FilterKind::gaussian, FilterKind::spline})
        for (const double cutoff : {0.8, 2.5})
            EXPECT_NEAR(passed(kind, cutoff, cutoff), 0.5, 0.004) << to_string(kind) << ' ' << cutoff;
}

/// ISO 16610-21: exp(-ln 2 (cut-off/wavelength)^2). ISO 16610-22: 1/(1 + (cut-off/wavelength)^4).
TEST(Filter, OtherWavelengthsPassAsTheStandardsSay) {
    for (const double ratio : {0.4, 0.6, 1.5, 3.0}) {
        const double length = 2.4, cutoff = ratio * length;
        EXPECT_NEAR(passed(FilterKind::gaussian, cutoff, length), std::exp(-std::log(2.0) * ratio * ratio), 0.004);
        EXPECT_NEAR(passed(FilterKind::spline, cutoff, length), 1.0 / (1.0 + std::pow(ratio, 4)), 0.004);
    }
}

/// The robust filter with small noise beside a short wave: what its weights do not touch passes by half as well.
TEST(Filter, HalfPassesTheRobustFilterWhereNoSampleIsAnOutlier) {
    const auto s = places(12);
    const auto long_wave = wave(s, 8.0), short_wave = wave(s, 2.0);
    std::vector<double> z(s.size());
    for (std::size_t i = 0; i < z.size(); ++i)
        z[i] = long_wave[i] + 0.1 * short_wave[i];
    const auto filtered = filter_profile(s, z, {FilterKind::robust_gaussian, 2.0});
    ASSERT_TRUE(filtered);
    EXPECT_NEAR(height(s, *filtered, 2.0) / 0.1, 0.5, 0.03);
    // Second order: (1 + u) exp(-u) of a wave, u = pi (0.7309 cut-off/wavelength)^2.
    const double u = pi * std::pow(0.7309134 * 2.0 / 8.0, 2);
    EXPECT_NEAR(height(s, *filtered, 8.0), (1.0 + u) * std::exp(-u), 0.01);
}

TEST(Filter, AStraightProfileIsKeptToItsEnds) {
    const auto s = places(13);
    std::vector<double> z;
    for (const double x : s)
        z.push_back(0.3 - 0.02 * x);
    for (const FilterKind kind : all_kinds) {
        const auto filtered = filter_profile(s, z, {kind, 2.5});
        ASSERT_TRUE(filtered);
        for (std::size_t i = 0; i < z.size(); ++i)
            ASSERT_NEAR((*filtered)[i], z[i], 1e-9) << to_string(kind) << " at " << s[i];
    }
}

/// On even steps, inside: the convolution with the standard's weights, summed here by itself.
TEST(Filter, GaussianIsTheStandardsConvolution) {
    core::Rng rng(5);
    const double step = 0.02, cutoff = 0.8, alpha = std::sqrt(std::log(2.0) / pi);
    std::vector<double> s, z;
    for (int i = 0; i < 600; ++i) {
        s.push_back(step * i);
        z.push_back(rng.normal());
    }
    const auto filtered = filter_profile(s, z, {FilterKind::gaussian, cutoff});
    ASSERT_TRUE(filtered);
    for (int i = 120; i < 480; i += 7) {
        double sum = 0.0;
        for (int k = 0; k < 600; ++k)
            sum += z[static_cast<std::size_t>(k)] * step / (alpha * cutoff) *
                   std::exp(-pi * std::pow(step * (k - i) / (alpha * cutoff), 2));
        EXPECT_NEAR((*filtered)[static_cast<std::size_t>(i)], sum, 2e-3 * 0.3) << i;
    }
}

TEST(Filter, SpikesPullTheGaussianButNotTheRobustFilter) {
    core::Rng rng(6);
    const auto s = places(14);
    std::vector<double> smooth = wave(s, 20.0), spiked;
    for (double& value : smooth)
        value = 0.01 * value + 1e-4 * rng.normal();
    spiked = smooth;
    for (std::size_t i = 20; i + 30 < spiked.size(); i += 37)
        for (std::size_t k = 0; k < 3; ++k)
            spiked[i + k] += 0.05;
    const auto off = [&](FilterKind kind) {
        const auto a = filter_profile(s, smooth, {kind, 2.5}), b = filter_profile(s, spiked, {kind, 2.5});
        double most = 0.0;
        for (std::size_t i = 0; i < s.size(); ++i)
            most = std::max(most, std::abs((*a)[i] - (*b)[i]));
        return most;
    };
    EXPECT_GT(off(FilterKind::gaussian), 2e-3);
    EXPECT_LT(off(FilterKind::robust_gaussian), 1e-4);
}

TEST(Filter, AClosedProfileHasNoEnds) {
    const double round = 20.0;
    const int n = 400;
    std::vector<double> s, z;
    for (int i = 0; i < n; ++i) {
        s.push_back(round * (i + 0.3 * std::sin(2.0 * pi * i / n)) / n);
        z.push_back(std::sin(2.0 * pi * s.back() * 8.0 / round));
    }
    for (const FilterKind kind : all_kinds) {
        const auto filtered = filter_profile(s, z, {kind, 2.5}, round);
        ASSERT_TRUE(filtered);
        // The same profile, begun elsewhere.
        const int shift = 137;
        std::vector<double> s2, z2;
        for (int i = 0; i < n; ++i) {
            const std::size_t from = static_cast<std::size_t>((i + shift) % n);
            s2.push_back(s[from] - s[shift] + (i + shift >= n ? round : 0.0));
            z2.push_back(z[from]);
        }
        const auto turned = filter_profile(s2, z2, {kind, 2.5}, round);
        ASSERT_TRUE(turned);
        for (int i = 0; i < n; ++i)
            ASSERT_NEAR((*turned)[static_cast<std::size_t>(i)], (*filtered)[static_cast<std::size_t>((i + shift) % n)],
                        1e-10)
                << to_string(kind);
        if (kind == FilterKind::robust_gaussian) continue;  // it takes the crests of a lone wave for spikes
        for (int i = 0; i < n; ++i)
            ASSERT_NEAR((*filtered)[static_cast<std::size_t>(i)], 0.5 * z[static_cast<std::size_t>(i)], 0.004);
    }
}

/// Two sides of 12 mm and two edges of 3 mm; the LE zone runs over the contour's end.
std::vector<ContourPoint> zoned() {
    std::vector<ContourPoint> contour;
    double s = 0.0;
    const auto stretch = [&](Zone zone, double length, double step) {
        for (double x = 0.0; x < length - 1e-9; x += step) {
            ContourPoint p;
            p.zone = zone;
            p.arc_length_mm = s;
            const double turn = 2.0 * pi * s / 30.0;
            p.position_mm = 30.0 / (2.0 * pi) * Vec2(std::cos(turn), std::sin(turn));
            contour.push_back(p);
            s += step;
        }
    };
    stretch(Zone::le, 1.5, 0.01);
    stretch(Zone::pressure, 12.0, 0.05);
    stretch(Zone::te, 3.0, 0.01);
    stretch(Zone::suction, 12.0, 0.05);
    stretch(Zone::le, 1.5, 0.01);
    return contour;
}

TEST(Filter, ZonesAreFilteredByThemselves) {
    const auto contour = zoned();
    std::vector<std::optional<double>> z;
    for (const ContourPoint& p : contour)
        z.emplace_back(p.zone == Zone::suction || p.zone == Zone::pressure ? std::sin(2.0 * pi * p.arc_length_mm / 0.8)
                                                                           : 5.0 + 0.1 * p.arc_length_mm);
    ZoneFilters filters;
    filters.at(Zone::suction) = filters.at(Zone::pressure) = {FilterKind::gaussian, 4.0};
    filters.at(Zone::te) = {FilterKind::gaussian, 0.8};
    // A gap of 2 mm in the pressure side, and beyond it another height: the filter does not reach across.
    std::size_t gap = 0;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        if (contour[i].zone != Zone::pressure || contour[i].arc_length_mm < 6.0) continue;
        if (contour[i].arc_length_mm < 8.0) {
            z[i].reset();
            ++gap;
        } else {
            z[i] = 3.0;
        }
    }
    ASSERT_GT(gap, 30U);
    const auto filtered = filter_zones(contour, z, filters);
    for (const auto& why : filtered.refused)
        EXPECT_EQ(why, "");
    for (std::size_t i = 0; i < contour.size(); ++i) {
        ASSERT_EQ(filtered.values[i].has_value(), z[i].has_value());
        if (!z[i]) continue;
        const double value = *filtered.values[i];
        if (contour[i].zone == Zone::le) {
            EXPECT_EQ(value, *z[i]) << "no filter there";
        } else if (contour[i].zone == Zone::te) {
            EXPECT_NEAR(value, *z[i], 1e-9) << "straight, and nothing of the sides";
        } else if (contour[i].zone == Zone::pressure && contour[i].arc_length_mm > 8.0) {
            EXPECT_NEAR(value, 3.0, 1e-9) << "nothing from beyond the gap";
        } else {
            EXPECT_LT(std::abs(value), 0.4) << "a fifth of the cut-off; at an end part of a wave is left";
        }
    }
}

TEST(Filter, SaysWhatItCannotFilter) {
    const auto s = places(1);
    const auto z = wave(s, 5.0);
    EXPECT_FALSE(filter_profile(s, std::vector<double>(3, 0.0), {FilterKind::gaussian, 0.8}));
    EXPECT_FALSE(filter_profile(s, z, {FilterKind::gaussian, 0.0}));
    EXPECT_FALSE(filter_profile(s, z, {FilterKind::spline, 50.0}));
    EXPECT_FALSE(filter_profile(s, z, {FilterKind::spline, 0.8}, 1.0));
    EXPECT_FALSE(
        filter_profile(std::vector<double>{0, 1, 1, 2, 3}, std::vector<double>(5, 0.0), {FilterKind::gaussian, 0.8}));
    EXPECT_TRUE(filter_profile(s, z, {}));
    auto contour = zoned();
    ZoneFilters filters;
    filters.at(Zone::te) = {FilterKind::gaussian, 8.0};
    const auto filtered = filter_zones(contour, std::vector<std::optional<double>>(contour.size(), 0.0), filters);
    for (const Zone zone : {Zone::le, Zone::suction, Zone::te, Zone::pressure})
        EXPECT_EQ(filtered.refused[static_cast<std::size_t>(zone)].empty(), zone != Zone::te);
    for (std::size_t i = 0; i < contour.size(); ++i)
        EXPECT_EQ(filtered.values[i].has_value(), contour[i].zone != Zone::te);
    for (const FilterKind kind : all_kinds)
        EXPECT_EQ(filter_kind_from(to_string(kind)), kind);
    EXPECT_FALSE(filter_kind_from("median"));
}

}  // namespace
}  // namespace cmm::fitting
