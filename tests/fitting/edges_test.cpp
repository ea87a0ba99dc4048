// SPDX-License-Identifier: Apache-2.0
#include "fitting/edges.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

std::vector<OffsetPoint> contour_of(const truth::Outline& outline) {
    std::vector<OffsetPoint> contour;
    for (std::size_t i = 0; i < outline.points.size(); i += 5)
        contour.push_back({outline.points[i], outline.normals[i], 0.0});
    return contour;
}

TEST(Edges, FindsNosesRadiiAndSidesOfTheParametricBlade) {
    truth::EnvelopeBlade blade{40, 4, 30, 0, 0.6, 0.3};
    const auto contour = contour_of(truth::envelope_blade(blade));
    const auto edges = find_edges(contour, {}, {});
    ASSERT_TRUE(edges) << edges.error().message;
    EXPECT_NEAR(edges->le.scale_mm, 0.6, 0.01);
    EXPECT_NEAR(edges->te.scale_mm, 0.3, 0.01);
    // On the parametric blade the nose is on the camber line's continuation, one radius beyond its ends.
    const double th = 30 * std::numbers::pi / 180, k = 40 - 0.9;
    const Vec2 le(-k / 2 - 0.6 * std::cos(th / 2), -0.6 * std::sin(th / 2)),
        te(k / 2 + 0.3 * std::cos(th / 2), -0.3 * std::sin(th / 2));
    EXPECT_LT((contour[edges->le.nose].position - le).norm(), 0.05);
    EXPECT_LT((contour[edges->te.nose].position - te).norm(), 0.05);
    const auto zones = zones_of(*edges, contour.size());
    for (std::size_t i = 0; i < contour.size(); ++i) {
        if (std::abs(contour[i].position.x()) > 15.0) continue;
        EXPECT_EQ(zones[i], contour[i].normal.y() > 0 ? Zone::suction : Zone::pressure);
    }
}

TEST(Edges, HintsDecideWhichEdgeLeads) {
    const auto contour = contour_of(truth::envelope_blade({40, 4, 30, 0, 0.6, 0.3}));
    const auto by_le = find_edges(contour, Vec2(30, 0), {}), by_te = find_edges(contour, {}, Vec2(-30, 0));
    ASSERT_TRUE(by_le && by_te);
    EXPECT_NEAR(by_le->le.scale_mm, 0.3, 0.01);
    EXPECT_NEAR(by_te->le.scale_mm, 0.3, 0.01);
    const auto zones = zones_of(*by_le, contour.size());
    for (std::size_t i = 0; i < contour.size(); ++i)
        if (std::abs(contour[i].position.x()) < 15.0) {
            EXPECT_EQ(zones[i], contour[i].normal.y() > 0 ? Zone::suction : Zone::pressure);
        }
}

TEST(Edges, ANoseLiesBetweenPoints) {
    // Of an ellipse the nose is the vertex, whichever points are beside it.
    constexpr int points = 240;
    for (const double shift : {0.1, 0.35, 0.8}) {
        std::vector<OffsetPoint> contour;
        for (int i = 0; i < points; ++i) {
            const double t = 2.0 * std::numbers::pi * (i + shift) / points;
            contour.push_back({{30.0 * std::cos(t), 5.0 * std::sin(t)},
                               Vec2(5.0 * std::cos(t), 30.0 * std::sin(t)).normalized(),
                               0.0});
        }
        const auto edges = find_edges(contour, Vec2(-30.0, 0.0), {});
        ASSERT_TRUE(edges);
        const double spacing = 5.0 * 2.0 * std::numbers::pi / points;
        EXPECT_LT(std::abs(nose_of(edges->le, contour).y()), 0.35 * spacing) << shift;
        EXPECT_LT(std::abs(nose_of(edges->te, contour).y()), 0.35 * spacing) << shift;
    }
}

TEST(Edges, ACircleHasNone) {
    std::vector<OffsetPoint> circle;
    for (int i = 0; i < 600; ++i) {
        const Vec2 n(std::cos(i * std::numbers::pi / 300), std::sin(i * std::numbers::pi / 300));
        circle.push_back({5.0 * n, n, 0.0});
    }
    EXPECT_FALSE(find_edges(circle, {}, {}));
    EXPECT_FALSE(find_edges({}, {}, {}));
}

}  // namespace
}  // namespace cmm::fitting
