// SPDX-License-Identifier: Apache-2.0
/// The radius of an edge in a window: of circles, and of ellipses, whose edge is no arc.
#include "fitting/edge_radius.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "fitting/circle.hpp"
#include "support/exact_scan.hpp"

namespace cmm::fitting {
namespace {

constexpr double rad_per_deg = std::numbers::pi / 180.0;

/// An ellipse with its LE at (-a, 0), displaced outwards by `off(t)` at the angle t.
SectionFit elliptic_section(double a, double b, const std::function<double(double)>& off = {}) {
    constexpr std::size_t n = 4000;
    SectionFit fit;
    for (std::size_t i = 0; i < n; ++i) {
        const double t = 2.0 * std::numbers::pi * static_cast<double>(i) / n;
        ContourPoint point;
        point.normal = Vec2(b * std::cos(t), a * std::sin(t)).normalized();
        point.position_mm = Vec2(a * std::cos(t), b * std::sin(t));
        if (off) {
            constexpr double h = 1e-4;
            const double way = std::hypot(a * std::sin(t), b * std::cos(t));
            const double slope = (off(t + h) - off(t - h)) / (2.0 * h * way);
            point.position_mm += off(t) * point.normal;
            point.normal = (point.normal - slope * left_of(point.normal)).normalized();
        }
        if (i > 0)
            point.arc_length_mm =
                fit.contour.back().arc_length_mm + (point.position_mm - fit.contour.back().position_mm).norm();
        fit.contour.push_back(point);
    }
    fit.le_point_mm = {-a, 0.0};
    fit.te_point_mm = {a, 0.0};
    return fit;
}

WindowRadius radius_of(const SectionFit& fit, const RadiusWindow& window) {
    MeasuredSection section(fit);
    const auto found = measure_edge_radius(section, EdgeName::le, window);
    EXPECT_TRUE(found) << (found ? "" : found.error().message);
    return found.value_or(WindowRadius{});
}

TEST(EdgeRadius, OfAnArcIsThatOfTheArcInAnyWindow) {
    const auto circle = elliptic_section(5.0, 5.0);
    for (const double arc : {70.0, 120.0, 175.0}) {
        const auto by_arc = radius_of(circle, {arc * rad_per_deg, {}});
        EXPECT_NEAR(by_arc.radius.value, 5.0, 1e-6) << arc;
        EXPECT_NEAR(by_arc.arc_rad, arc * rad_per_deg, 1e-9) << arc;
        EXPECT_LT(by_arc.rms_mm, 1e-6);
        // Chord from the nose to where that window ends.
        const auto by_reach = radius_of(circle, {{}, 10.0 * std::sin(0.25 * arc * rad_per_deg)});
        EXPECT_NEAR(by_reach.arc_rad, arc * rad_per_deg, 1e-4) << arc;
        EXPECT_NEAR(by_reach.radius.value, 5.0, 1e-6) << arc;
    }
}

TEST(EdgeRadius, OfAnEllipseIsThatOfTheCircleThroughTheWindow) {
    const auto section = elliptic_section(6.0, 2.0);
    // Turn of the normal against -x at the angle t.
    const auto turn = [](double t) { return std::atan2(6.0 * std::sin(t), -2.0 * std::cos(t)); };
    for (const double arc : {80.0, 140.0}) {
        const auto found = radius_of(section, {arc * rad_per_deg, {}});
        std::vector<Vec2> points;  // dense, even in length
        double length = 0.0;
        Vec2 before(-6.0, 0.0);
        for (double t = std::numbers::pi - 1.5; t < std::numbers::pi + 1.5; t += 1e-5) {
            const Vec2 p(6.0 * std::cos(t), 2.0 * std::sin(t));
            length += (p - before).norm();
            before = p;
            if (std::abs(turn(t)) > 0.5 * arc * rad_per_deg || length < 0.001) continue;
            length = 0.0;
            points.push_back(p);
        }
        const auto truth = fit_circle(points);
        ASSERT_TRUE(truth);
        EXPECT_NEAR(found.radius.value, truth->radius, 5e-4 * truth->radius) << arc;
        EXPECT_NEAR(found.rms_mm, truth->rms, 0.05 * truth->rms) << arc;
        EXPECT_GT(found.radius.value, 4.0 / 6.0) << "at the nose it is b^2 / a";
    }
}

TEST(EdgeRadius, AnswersToDisplacementsAsItSays) {
    for (const auto& [a, b] : {std::pair{5.0, 5.0}, std::pair{5.0, 3.0}, std::pair{6.0, 2.0}}) {
        const RadiusWindow window{120.0 * rad_per_deg, {}};
        const auto plain = radius_of(elliptic_section(a, b), window);
        constexpr double height = 1e-6;
        for (const double waves : {0.0, 1.0, 4.0, 9.0}) {
            const auto shape = [waves](double t) { return std::cos(waves * t + 0.3); };
            const auto moved = radius_of(elliptic_section(a, b, [&](double t) { return height * shape(t); }), window);
            double said = 0.0;
            for (const auto& [point, weight] : plain.radius.slopes.parts())
                said += weight * shape(2.0 * std::numbers::pi * static_cast<double>(point) / 4000.0);
            EXPECT_NEAR(said, (moved.radius.value - plain.radius.value) / height, 0.05 + 0.05 * std::abs(said))
                << a << ' ' << b << ' ' << waves;
        }
    }
}

/// Scans of one section with normal noise, and what a window of its LE says.
struct Windows {
    std::size_t scans = 0, given = 0, covered = 0;
    double worst = 0.0;  ///< error in U95
    double u95_mm = 0.0;
};

core::Result<WindowRadius> measure(const SectionFit& fit, double arc_deg, double* u95_mm = nullptr) {
    MeasuredSection section(fit);
    auto found = measure_edge_radius(section, EdgeName::le, {arc_deg * rad_per_deg, {}});
    if (found && u95_mm != nullptr) *u95_mm = section.uncertainty(found->radius).u95;
    return found;
}

SectionFit fit_of(const section_truth::ExactSection& section, double noise_mm, unsigned seed) {
    auto points = section_truth::exact_scan(section, 1.0, {144, 456, 144, 456});
    std::mt19937_64 generator(seed);
    std::normal_distribution<double> normal(0.0, 1.0);
    for (Vec2& point : points)
        point += noise_mm * Vec2(normal(generator), normal(generator));
    SectionOptions options;
    options.le_hint = section.at(section.le_nose).position;
    options.te_hint = section.at(section.te_nose).position;
    auto fit = fit_section(points, {}, options);
    EXPECT_TRUE(fit) << (fit ? "" : fit.error().message);
    return fit ? std::move(*fit) : SectionFit{};
}

Windows windows_of(const section_truth::ExactSection& section, double arc_deg, double noise_mm, double truth_mm) {
    Windows windows;
    for (unsigned seed = 1; seed <= 30; ++seed) {
        double u95 = 0.0;
        const auto found = measure(fit_of(section, noise_mm, seed), arc_deg, &u95);
        ++windows.scans;
        if (!found) {
            EXPECT_NE(found.error().message.find("over the joint"), std::string::npos) << found.error().message;
            continue;
        }
        ++windows.given;
        const double error = std::abs(found->radius.value - truth_mm);
        if (error <= u95) ++windows.covered;
        windows.worst = std::max(windows.worst, error / u95);
        windows.u95_mm = std::max(windows.u95_mm, u95);
    }
    return windows;
}

/// The arc turns by 133 degrees, but its middle is not the nose: it ends 59 degrees on one side of it, 75 on the other.
TEST(EdgeRadius, IsRefusedWhereTheWindowReachesOverAJoint) {
    const auto turbine = section_truth::envelope(50.0, 12.0, 80.0 * rad_per_deg, 3.0, 0.8);
    EXPECT_FALSE(measure(fit_of(turbine, 0.0, 1), 124.0));
    for (const double noise_mm : {0.001, 0.005}) {
        EXPECT_EQ(windows_of(turbine, 124.0, noise_mm, 3.0).given, 0u) << noise_mm;
        for (const double arc_deg : {62.0, 116.0}) {
            const Windows clear = windows_of(turbine, arc_deg, noise_mm, 3.0);
            EXPECT_EQ(clear.given, clear.scans) << arc_deg;
            EXPECT_GE(clear.covered, 26u) << arc_deg;
            EXPECT_LT(clear.worst, 2.0) << arc_deg;
            EXPECT_LT(clear.u95_mm, (arc_deg < 100.0 ? 3.8 : 1.2) * noise_mm) << arc_deg;
        }
        // The end lies about on the joint: where there is a number, it is honest.
        EXPECT_LT(windows_of(turbine, 118.0, noise_mm, 3.0).worst, 2.0) << noise_mm;
    }
}

TEST(EdgeRadius, KnowsThatItsWindowGoesWithTheNormals) {
    const auto naca = section_truth::naca_4_digit(60.0, 0.12, 0.04, 0.4, 0.25);
    const auto exact = measure(fit_of(naca, 0.0, 1), 124.0);
    ASSERT_TRUE(exact);
    const Windows windows = windows_of(naca, 124.0, 0.001, exact->radius.value);
    EXPECT_EQ(windows.given, windows.scans);
    EXPECT_GE(windows.covered, 26u);
    EXPECT_LT(windows.worst, 2.0);
}

TEST(EdgeRadius, IsRefusedWhereTheWindowIsNoEdge) {
    const auto fit = elliptic_section(6.0, 2.0);
    MeasuredSection section(fit);
    const auto small = measure_edge_radius(section, EdgeName::te, {{}, 0.2});
    ASSERT_FALSE(small);
    EXPECT_NE(small.error().message.find("too short for a radius (60 degrees)"), std::string::npos)
        << small.error().message;
    const auto far = measure_edge_radius(section, EdgeName::le, {{}, 11.0});
    ASSERT_FALSE(far);
    EXPECT_NE(far.error().message.find("beyond the edge"), std::string::npos);
    EXPECT_FALSE(measure_edge_radius(section, EdgeName::le, {250.0 * rad_per_deg, {}}));
}

}  // namespace
}  // namespace cmm::fitting
