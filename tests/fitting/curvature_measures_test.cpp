// SPDX-License-Identifier: Apache-2.0
/// The mean curvature over a window against circles, ellipses and NACA sections, and how it answers to displacements.
#include "fitting/curvature_measures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "fitting/section.hpp"
#include "support/exact_scan.hpp"
#include "support/section_truth.hpp"
#include "support/true_curvature.hpp"

namespace cmm::fitting {
namespace {

using section_truth::OutlineJet;
constexpr double whole_turn = 2.0 * std::numbers::pi;

/// Points of a closed outline, each moved along its normal.
std::vector<ContourPoint> contour_of(
    const std::function<OutlineJet(double)>& at, std::size_t count,
    const std::function<double(double)>& moved = [](double) { return 0.0; }) {
    std::vector<ContourPoint> contour(count);
    const auto place = [&](double t) -> Vec2 {
        const auto jet = at(t);
        return jet.position + moved(t) * jet.normal();
    };
    constexpr double step = 1e-5;
    for (std::size_t i = 0; i < count; ++i) {
        const double t = 4.0 * static_cast<double>(i) / static_cast<double>(count);
        const Vec2 tangent = place(t + step) - place(t - step);
        contour[i].position_mm = place(t);
        contour[i].normal = Vec2(tangent.y(), -tangent.x()).normalized();
        if (i > 0)
            contour[i].arc_length_mm =
                contour[i - 1].arc_length_mm + (contour[i].position_mm - contour[i - 1].position_mm).norm();
    }
    return contour;
}

std::function<OutlineJet(double)> ellipse(double a, double b) {
    return [=](double t) {
        const double w = whole_turn / 4.0, c = std::cos(w * t), s = std::sin(w * t);
        return OutlineJet{Vec2(a * c, b * s), w * Vec2(-a * s, b * c), w * w * Vec2(-a * c, -b * s)};
    };
}

TEST(MeanCurvature, OfACircleIsOneOverItsRadius) {
    for (const double radius : {0.2, 7.0}) {
        const auto points = contour_of(ellipse(radius, radius), 600);
        const ContourGeometry contour(points);
        for (const double share : {0.05, 0.3})
            for (const double at : {0.0, 0.37, 0.99, 1.2})  // also over the end of the contour
                EXPECT_NEAR(MeanCurvature(contour, share * contour.perimeter()).at(at * contour.perimeter()) * radius,
                            1.0, 1e-5);
    }
}

TEST(MeanCurvature, OfAnEllipseIsTheWeightedMeanOfItsFormula) {
    const auto outline = ellipse(6.0, 2.0);
    const TrueCurvature truth(outline);
    const auto points = contour_of(outline, 2400);
    const ContourGeometry contour(points);
    for (const double window : {0.4, 3.0}) {
        const MeanCurvature mean(contour, window);
        for (double share = 0.0; share < 1.0; share += 0.0371)
            EXPECT_NEAR(mean.at(share * contour.perimeter()), truth.mean(share * truth.perimeter(), window), 2e-5)
                << window << " " << share;
    }
    // At the end of the long axis a window of no length would say a / b^2.
    EXPECT_LT(MeanCurvature(contour, 3.0).at(0.0), 0.7 * 6.0 / 4.0);
    EXPECT_NEAR(MeanCurvature(contour, 0.1).at(0.0), 6.0 / 4.0, 2e-3);
}

TEST(MeanCurvature, AnswersToDisplacementsAsItSays) {
    const auto outline = ellipse(6.0, 2.0);
    const auto plain_points = contour_of(outline, 2400);
    const ContourGeometry plain(plain_points);
    constexpr double height = 1e-6;
    for (const double middle : {0.0, 0.5, 1.0, 2.2}) {
        // Waves that the windows hold several of, and one that is longer than they are.
        for (const double waves : {1.0, 6.0, 25.0}) {
            const auto shape = [&](double t) { return std::sin(waves * whole_turn / 4.0 * t + 0.4); };
            const auto moved_points = contour_of(outline, 2400, [&](double t) { return height * shape(t); });
            const ContourGeometry moved(moved_points);
            const auto i = static_cast<std::size_t>(middle * 600.0);
            for (const double window : {0.5, 3.0}) {
                const double before = MeanCurvature(plain, window).at(plain.point(i).arc_length_mm);
                const double after = MeanCurvature(moved, window).at(moved.point(i).arc_length_mm);
                double said = 0.0;
                const Sensitivity slopes = MeanCurvature(plain, window).slopes(plain.point(i).arc_length_mm);
                for (const auto& [point, weight] : slopes.parts())
                    said += weight * shape(4.0 * static_cast<double>(point) / 2400.0);
                const double measured = (after - before) / height;
                EXPECT_NEAR(said, measured, 0.01 * std::abs(measured) + 0.01)
                    << middle << " " << waves << " " << window;
            }
        }
    }
}

/// Through the whole fit, without noise.
TEST(MeanCurvature, OfMeasuredNacaSections) {
    for (const auto& [thickness, camber] : {std::pair{0.12, 0.0}, std::pair{0.10, 0.04}}) {
        const auto naca = section_truth::naca_4_digit(50.0, thickness, camber, 0.4, 0.2);
        SectionOptions options;
        options.le_hint = naca.at(naca.le_nose).position;
        options.te_hint = naca.at(naca.te_nose).position;
        const auto fit = fit_section(section_truth::exact_scan(naca, 1.0, {400, 800, 400, 800}), {}, options);
        ASSERT_TRUE(fit) << fit.error().message;
        const ContourGeometry contour(fit->contour);
        const TrueCurvature truth([&](double t) { return naca.at(t); });
        constexpr double window = 2.0;
        const MeanCurvature mean(contour, window);
        double largest = 0.0;
        for (const double side : {1.0, 3.0}) {
            for (double share = 0.1; share < 0.9; share += 0.02) {
                const double t = side + share;
                const double s = truth.arc_of(t);
                if (s - truth.arc_of(side) < window || truth.arc_of(side + 0.999) - s < window) continue;
                const auto place = contour.foot(naca.at(t).position, contour.whole());
                largest = std::max(largest, std::abs(mean.at(contour.arc(place)) - truth.mean(s, window)));
            }
        }
        EXPECT_LT(largest, 2e-5) << "1/mm, of curvatures from 0 to 0.05";
        EXPECT_GT(largest, 0.0);
    }
}

}  // namespace
}  // namespace cmm::fitting
