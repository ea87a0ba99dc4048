// SPDX-License-Identifier: Apache-2.0
/// Uncertainties of min-max motions. That they hold the truth characteristic_coverage_test.cpp shows.
#include "fitting/drawn_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "fitting/datum.hpp"
#include "support/families.hpp"
#include "support/formed_nominal.hpp"

namespace cmm::fitting {
namespace {

SectionFit scan_of(const families::Blade& blade, std::uint64_t seed) {
    families::ScanOptions scanning;
    scanning.bad_share = 0.0;
    scanning.seed = seed;
    SectionOptions options;
    options.ball_radius_mm = scanning.ball_mm;
    options.le_hint = blade.le().nose;
    options.te_hint = blade.te().nose;
    return fit_section(families::scan(blade, scanning).points, {}, options).value();
}

BestFit min_max(const MeasuredSection& section, const ClosedCurve& nominal, bool turn = true) {
    BestFitOptions options;
    options.objective = FitObjective::min_max;
    options.rotate = turn;
    return fit_to_nominal(section.contour(), nominal, options).value();
}

/// A scan of a blade against itself, or against a nominal of another form.
struct Laid {
    explicit Laid(std::uint64_t seed, double form_mm = 0.0)
        : blade(families::make(families::Family::fan, seed)),
          fit(scan_of(blade, seed)),
          section(fit),
          nominal(form_mm > 0.0 ? formed::of_other_form(blade, form_mm, seed).curve : formed::itself(blade)) {}

    families::Blade blade;
    SectionFit fit;
    MeasuredSection section;
    ClosedCurve nominal;
};

TEST(DrawnMotion, TheCovarianceOfPlacesIsThatOfNumbersOfThem) {
    const Laid subject(3);
    const auto& contour = subject.fit.contour;
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < contour.size(); i += 37)
        places.push_back(i);
    const Eigen::MatrixXd covariance = subject.fit.contour_noise.covariance(contour, places);
    Sensitivity number;
    Eigen::VectorXd weights(covariance.rows());
    for (Eigen::Index k = 0; k < weights.size(); ++k) {
        weights[k] = std::cos(0.7 * static_cast<double>(k));
        number.add(places[static_cast<std::size_t>(k)], weights[k]);
    }
    const double variance = subject.fit.contour_noise.variance(contour, number);
    EXPECT_NEAR(weights.dot(covariance * weights) / variance, 1.0, 1e-6);
}

/// Two of the four places that a motion rests on often lie side by side, and weigh fifty times what they tell.
TEST(DrawnMotion, UncertaintiesAreAlikeFromScanToScan) {
    std::vector<double> drawn, by_four;
    for (std::uint64_t seed = 1; seed <= 120; ++seed) {
        const Laid subject(seed);
        const BestFit found = min_max(subject.section, subject.nominal);
        const MeasuredSection* const only = &subject.section;
        const double share = 1.0 / subject.fit.centres.curve.sigma_mm;
        drawn.push_back(share * std::sqrt(datums_of(found, {&only, 1}).front().covariance(0, 0)));
        by_four.push_back(share *
                          std::sqrt(subject.fit.contour_noise.variance(subject.fit.contour, found.slopes[0][0])));
    }
    const auto most_to_median = [](std::vector<double>& values) {
        std::sort(values.begin(), values.end());
        return values.back() / values[values.size() / 2];
    };
    EXPECT_LT(most_to_median(drawn), 3.0);
    EXPECT_GT(most_to_median(by_four), 10.0) << "or the case is none";
}

TEST(DrawnMotion, FollowsAMovedBladeAsAWhole) {
    const Laid subject(5, 0.005);
    const BestFit found = min_max(subject.section, subject.nominal);
    const MeasuredSection* const only = &subject.section;
    const auto drawn = draw_motions(found, {&only, 1});
    ASSERT_TRUE(drawn);
    // Displaced by one millimetre in x, a contour lies off by its normals' x.
    Eigen::Vector3d moved = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k)
        for (const auto& [point, weight] : drawn->slopes[0][k].parts()) {
            const auto& normal = subject.fit.contour[point].normal;
            moved[static_cast<Eigen::Index>(k)] += weight * normal.x();
        }
    EXPECT_NEAR(moved.x(), 1.0, 5e-3) << "normals of contour and nominal differ by the noise";
    EXPECT_NEAR(moved.y(), 0.0, 5e-3);
    EXPECT_NEAR(moved.z(), 0.0, 5e-4);
}

TEST(DrawnMotion, WhatMayNotMoveHasNone) {
    const Laid subject(7, 0.005);
    const BestFit found = min_max(subject.section, subject.nominal, false);
    const MeasuredSection* const only = &subject.section;
    const Datum datum = datums_of(found, {&only, 1}).front();
    EXPECT_EQ(datum.covariance(2, 2), 0.0);
    EXPECT_EQ(datum.covariance(0, 2), 0.0);
    EXPECT_GT(datum.covariance(0, 0), 0.0);
}

TEST(DrawnMotion, IsTheSameEachTimeAndNothingOfLeastSquares) {
    const Laid subject(9, 0.005);
    const MeasuredSection* const only = &subject.section;
    const BestFit found = min_max(subject.section, subject.nominal);
    EXPECT_EQ(draw_motions(found, {&only, 1})->covariance, draw_motions(found, {&only, 1})->covariance);
    const BestFit squares = fit_to_nominal(subject.section.contour(), subject.nominal).value();
    EXPECT_FALSE(draw_motions(squares, {&only, 1}));
}

}  // namespace
}  // namespace cmm::fitting
