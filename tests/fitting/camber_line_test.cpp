// SPDX-License-Identifier: Apache-2.0
/// How the camber line goes on to nose and tail, where it does not simply bend.
#include <gtest/gtest.h>

#include "fitting/measured_section.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::fitting {
namespace {

/// Half way up this fan the camber line near the LE bends one way on the lower and the other way on the upper sections,
/// and both ways between: the circle that is nearest to such points is a small one, by which the nose would be up to
/// 17 um off.
TEST(CamberLine, GoesOnAcrossTheEdgeWhereItBendsBothWays) {
    const families::TwistedBlade blade(families::Family::fan, 6);
    for (double z_mm = 0.5 * blade.height() - 1.0; z_mm < 0.5 * blade.height() + 0.6; z_mm += 0.05) {
        const families::Blade outline = blade.outline(z_mm);
        families::ScanOptions scanning;
        scanning.sigma_mm = scanning.bad_share = 0.0;
        SectionOptions options;
        options.ball_radius_mm = scanning.ball_mm;
        options.le_hint = outline.le().nose;
        options.te_hint = outline.te().nose;
        const auto fit = fit_section(families::scan(outline, scanning).points, {}, options);
        ASSERT_TRUE(fit) << fit.error().message;
        MeasuredSection section(*fit);
        ASSERT_TRUE(section.camber()) << section.camber().error().message;
        const Vec2 off = section.camber()->le().point() - outline.le().nose, inward = outline.le().inward;
        EXPECT_NEAR(inward.x() * off.y() - inward.y() * off.x(), 0.0, 1e-4) << z_mm;
    }
}

}  // namespace
}  // namespace cmm::fitting
