// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "fitting/live_spline.hpp"
#include "support/random_values.hpp"

namespace cmm::fitting {
namespace {

const int live_seeded = same_cases(1000);

/// Part of an ellipse with noise and bad points, counter-clockwise.
std::vector<Vec2> any_scan() {
    const double a = *real(1.0, 40.0), b = *real(1.0, 40.0), pitch = *real(0.02, 0.3), noise = *real(1e-4, 4e-3);
    const auto n = *whole<std::size_t>(20, 120);
    const auto steps = *rc::gen::container<std::vector<double>>(n, real(0.8, 1.2));
    const auto off = *rc::gen::container<std::vector<double>>(n, real(-1.7, 1.7));
    double t = *real(0.0, 6.0);
    std::vector<Vec2> scan;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 slope(-a * std::sin(t), b * std::cos(t));
        const double bad = *whole(0, 40) == 0 ? *real(-0.4, 0.4) : 0.0;
        scan.push_back(Vec2(a * std::cos(t), b * std::sin(t)) +
                       (noise * off[i] + bad) * right_normal(slope).normalized());
        t += steps[i] * pitch / slope.norm();
    }
    return scan;
}

RC_GTEST_PROP(LiveProperties, AMovedScanGivesTheMovedCurve, ()) {
    const auto scan = any_scan();
    const Eigen::Rotation2Dd turn(*real(-3.0, 3.0));
    const Vec2 shift = *point(20.0);
    LiveSpline here(MaterialSide::left), there(MaterialSide::left);
    for (std::size_t i = 0; i < scan.size(); ++i) {
        here.add(i, scan[i]);
        there.add(i, turn * scan[i] + shift);
        const auto p = here.newest(), q = there.newest();
        RC_ASSERT(p.valid == q.valid && p.doubtful == q.doubtful);
        RC_ASSERT((turn * p.position + shift - q.position).norm() < 1e-9 || !p.valid);
        RC_ASSERT(std::abs(p.curvature - q.curvature) < 1e-7 * (1.0 + std::abs(p.curvature)));
        RC_ASSERT(std::abs(p.sigma_mm - q.sigma_mm) < 1e-9);
        RC_ASSERT((turn * here.predict(0.1).centre + shift - there.predict(0.1).centre).norm() < 1e-9 || !p.valid);
    }
}

RC_GTEST_PROP(LiveProperties, AMirroredScanHasTheMaterialOnTheOtherSide, ()) {
    const auto scan = any_scan();
    LiveSpline left(MaterialSide::left), right(MaterialSide::right);
    for (std::size_t i = 0; i < scan.size(); ++i) {
        left.add(i, scan[i]);
        right.add(i, {scan[i].x(), -scan[i].y()});
        const auto p = left.newest(), q = right.newest();
        RC_ASSERT(p.valid == q.valid && p.doubtful == q.doubtful);
        if (!p.valid) continue;
        RC_ASSERT(std::abs(p.curvature - q.curvature) < 1e-9 * (1.0 + std::abs(p.curvature)));
        RC_ASSERT((Vec2(p.normal.x(), -p.normal.y()) - q.normal).norm() < 1e-9);
        RC_ASSERT(std::abs(left.turned_rad() - right.turned_rad()) < 1e-9);
    }
}

RC_GTEST_PROP(LiveProperties, NothingComesOfGarbage, ()) {
    LiveSpline curve(*rc::gen::arbitrary<bool>() ? MaterialSide::left : MaterialSide::right);
    std::uint64_t sequence = 0;
    for (const Vec2& point : garbage_points(120)) {
        sequence += *whole<std::uint64_t>(1, 3);
        curve.add(*whole(0, 8) == 0 ? sequence / 2 : sequence, point, *whole(0, 8) == 0);
        for (const std::size_t back : {std::size_t{0}, LiveSpline::lag / 2, LiveSpline::lag, LiveSpline::lag + 1}) {
            const auto p = curve.point(back);
            RC_ASSERT(is_finite(p.position) && is_finite(p.tangent) && std::isfinite(p.curvature));
            RC_ASSERT(p.sigma_mm >= 0.0 && std::isfinite(p.sigma_mm));
        }
        const auto next = curve.predict(*real(0.0, 2.0));
        RC_ASSERT(is_finite(next.centre) && is_finite(next.normal) && std::isfinite(next.sigma_mm));
        const double step = curve.suggest_step(0.05, 0.4, 0.001);
        RC_ASSERT(step >= 0.05 && step <= 0.4);
        RC_ASSERT(std::isfinite(curve.noise_mm()) && curve.noise_mm() > 0.0);
        RC_ASSERT(std::isfinite(curve.length_mm()) && std::isfinite(curve.turned_rad()));
        (void)curve.closed();
    }
}

}  // namespace
}  // namespace cmm::fitting
