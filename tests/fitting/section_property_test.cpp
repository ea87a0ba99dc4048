// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

#include "fitting/section.hpp"
#include "fitting/thickness.hpp"
#include "fitting/vec2.hpp"
#include "support/families.hpp"
#include "support/random_values.hpp"

namespace cmm::fitting {
namespace {

const int seeded = same_cases(60);
constexpr double same_mm = 1e-9;

/// A scan of a blade of the three families, with noise and bad points.
std::vector<Vec2> any_scan() {
    const auto family = *rc::gen::elementOf(families::all_families);
    families::ScanOptions options;
    options.points = *whole<std::size_t>(300, 900);
    options.sigma_mm = *real(0.0, 0.003);
    options.seed = *whole<std::uint64_t>(1, 1'000'000);
    return families::scan(families::make(family, *whole<std::uint64_t>(1, 1'000'000)), options).points;
}

void same_contour(const std::vector<ContourPoint>& a, const std::vector<ContourPoint>& b, double scale,
                  const auto& move) {
    RC_ASSERT(a.size() == b.size());
    double worst = 0.0, uncertainty = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        worst = std::max(worst, (move(a[i].position_mm) - b[i].position_mm).norm());
        uncertainty = std::max(uncertainty, std::abs(scale * a[i].u95_mm - b[i].u95_mm));
        RC_ASSERT(a[i].zone == b[i].zone);
    }
    RC_ASSERT(worst < same_mm);
    RC_ASSERT(uncertainty < same_mm);
}

void same_fit(const std::vector<Vec2>& points, const std::vector<Vec2>& others, const auto& move) {
    const auto a = fit_section(points, {}, {}), b = fit_section(others, {}, {});
    RC_ASSERT(a.has_value());
    RC_ASSERT(b.has_value());
    RC_ASSERT(a->rejected == b->rejected);
    same_contour(a->contour, b->contour, 1.0, move);
    RC_ASSERT(std::abs(a->chord_mm - b->chord_mm) < same_mm);
    RC_ASSERT(std::abs(largest_inscribed_diameter(a->contour) - largest_inscribed_diameter(b->contour)) < same_mm);
    RC_ASSERT(std::abs(a->le.radius_mm - b->le.radius_mm) < same_mm);
    RC_ASSERT(std::abs(a->te.radius_mm - b->te.radius_mm) < same_mm);
}

RC_GTEST_PROP(SectionProperties, MovesWithItsPoints, ()) {
    const auto points = any_scan();
    const double angle = *real(-3.0, 3.0);
    const Vec2 shift = *point(100.0);
    Eigen::Matrix2d turn;
    turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    const auto move = [&](const Vec2& p) { return Vec2(turn * p + shift); };
    std::vector<Vec2> moved;
    for (const Vec2& p : points)
        moved.push_back(move(p));
    same_fit(points, moved, move);
}

RC_GTEST_PROP(SectionProperties, ForgetsTheDirectionOfTheScan, ()) {
    const auto points = any_scan();
    const std::vector<Vec2> reversed(points.rbegin(), points.rend());
    same_fit(points, reversed, [](const Vec2& p) { return p; });
}

RC_GTEST_PROP(SectionProperties, GarbageGivesAResultOrAnError, ()) {
    const auto points = garbage_points(60);
    std::vector<RejectReason> excluded;
    if (*rc::gen::arbitrary<bool>())
        excluded.resize(*rc::gen::element(points.size(), points.size() / 2), RejectReason::none);
    for (RejectReason& reason : excluded)
        if (*whole(0, 5) == 0) reason = RejectReason::no_contact;
    SectionOptions options;
    if (*rc::gen::arbitrary<bool>()) options.ball_radius_mm = *garbage();
    if (*whole(0, 4) == 0) options.le_hint = Vec2(*garbage(), *garbage());
    if (*whole(0, 4) == 0) options.reject_floor_mm = *garbage();
    if (*whole(0, 4) == 0) options.gap_factor = *garbage();
    if (*whole(0, 4) == 0) options.lean_rad = *garbage();
    const auto fit = fit_section(points, excluded, options);
    if (fit) RC_ASSERT(fit->verdicts.size() == points.size());
}

/// A good scan with some of its numbers broken: what a bad line or a bad register delivers.
RC_GTEST_PROP(SectionProperties, ABrokenScanGivesAResultOrAnError, ()) {
    auto points = any_scan();
    for (int k = *whole(1, 20); k > 0; --k) {
        Vec2& p = points[*whole<std::size_t>(0, points.size())];
        p = *rc::gen::arbitrary<bool>() ? Vec2(*garbage(), p.y()) : points[*whole<std::size_t>(0, points.size())];
    }
    const auto fit = fit_section(points, {}, {});
    if (fit) RC_ASSERT(fit->verdicts.size() == points.size());
}

}  // namespace
}  // namespace cmm::fitting
