// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "core/rng.hpp"
#include "fitting/closest_point.hpp"

namespace cmm::fitting {
namespace {

constexpr double round_rad = 2.0 * std::numbers::pi;

PiecewiseCubic through(std::size_t count, const std::function<Vec2(double)>& at) {
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < count; ++i)
        points.push_back(at(round_rad * static_cast<double>(i) / static_cast<double>(count)));
    return interpolate_periodic(points, chord_parameters(points, true));
}

/// Curves that come near to themselves in every way: thin, bent, as a needle, crossing, waved, with edges of a span.
std::vector<PiecewiseCubic> narrow_curves() {
    const auto ellipse = [](double length, double width) {
        return [=](double a) { return Vec2(length * std::cos(a), width * std::sin(a)); };
    };
    std::vector<PiecewiseCubic> curves;
    for (const std::size_t count : {120U, 700U, 2400U}) {
        curves.push_back(through(count, [](double a) -> Vec2 {
            return {30.0 * std::cos(a), 2.5 * std::sin(a) + 8.0 * std::cos(a) * std::cos(a)};
        }));
        curves.push_back(through(count, ellipse(30.0, 0.05)));
        curves.push_back(through(count, ellipse(30.0, 0.005)));
        curves.push_back(through(count, [](double a) { return Vec2(5.0 * std::sin(a), 2.0 * std::sin(2.0 * a)); }));
        curves.push_back(through(count, [](double a) {
            const double r = 20.0 + 0.1 * std::cos(40.0 * a);
            return Vec2(r * std::cos(a), 0.2 * r * std::sin(a));
        }));
        curves.push_back(through(count, [](double a) {
            const double r = 10.0 + 9.9 * std::cos(a);  // nearly a cardioid's cusp
            return Vec2(r * std::cos(a), r * std::sin(a));
        }));
    }
    return curves;
}

/// The search without clearances has its own proof and its own tests.
TEST(Clearance, ChangesNoAnswer) {
    core::Rng rng(5);
    for (const PiecewiseCubic& curve : narrow_curves()) {
        const ClosestPointIndex plain(curve);
        ClosestPointIndex clear(curve);
        clear.note_clearances();
        const double span_mm = curve.period() / static_cast<double>(curve.spans());
        for (int i = 0; i < 3000; ++i) {
            double t = curve.front() + curve.period() * rng.uniform();
            const std::size_t span = curve.span_of(t), beside = static_cast<std::size_t>(rng.uniform(0.0, 6.0));
            const Jet jet = curve.jet(t);
            const double reach = span_mm * std::pow(10.0, rng.uniform(-3.0, 1.5));
            const Vec2 p = jet.position + rng.uniform(-reach, reach) * jet.right_normal();
            const double expected = std::sqrt(plain.closest(p).squared);
            EXPECT_NEAR(std::sqrt(clear.closest(p, (span + beside) % curve.spans()).squared), expected, 1e-10);
        }
    }
}

}  // namespace
}  // namespace cmm::fitting
