// SPDX-License-Identifier: Apache-2.0
#include "fitting/thickness.hpp"

#include <gtest/gtest.h>

#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

double thickness_of(const truth::Outline& outline) {
    std::vector<ContourPoint> contour;
    for (std::size_t i = 0; i < outline.points.size(); i += 6) {
        auto& point = contour.emplace_back();
        point.position_mm = outline.points[i];
        point.normal = outline.normals[i];
    }
    return largest_inscribed_diameter(contour);
}

TEST(Thickness, IsTheLargestCircleOfTheEnvelope) {
    // rho(t) of docs/part-file.md at its maximum, found by sampling: the sides are the envelope of these very circles.
    for (const double camber : {0.0, 30.0, 60.0}) {
        const truth::EnvelopeBlade blade{40, 4, camber, 20, 0.6, 0.3};
        double largest = 0.0;
        for (int k = 0; k <= 100000; ++k) {
            const double t = k / 100000.0, h = 2.0 - 0.45;
            largest =
                std::max(largest, 0.6 * (1 - t) + 0.3 * t + h * 0.5 * (4 * t * (1 - t) + 6.75 * t * (1 - t) * (1 - t)));
        }
        EXPECT_NEAR(thickness_of(truth::envelope_blade(blade)), 2.0 * largest, 0.001) << camber;
    }
}

}  // namespace
}  // namespace cmm::fitting
