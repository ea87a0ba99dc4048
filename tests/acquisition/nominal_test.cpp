// SPDX-License-Identifier: Apache-2.0
#include "acquisition/nominal.hpp"

#include <gtest/gtest.h>

#include <array>

#include "acquisition/contour_sampling.hpp"
#include "acquisition/nominal_kinds.hpp"
#include "core/text.hpp"
#include "tests/acquisition/test_blade.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;

std::shared_ptr<const Nominal> parametric(const ParametricBlade& blade) {
    const auto nominal = parametric_nominal(blade);
    EXPECT_TRUE(nominal) << nominal.error().text();
    return nominal.value_or(nullptr);
}

NominalContour cut(const Nominal& nominal, double z) {
    const auto contour = nominal.cut(z);
    EXPECT_TRUE(contour) << contour.error().text();
    return contour.value_or(NominalContour{});
}

/// Signed distance of a point to the union of the blade's inscribed circles, straight from the document.
double distance_to_circles(const ParametricBlade& b, double z, Vector2d p) {
    const double s = (z - b.z_root_mm) / (b.z_tip_mm - b.z_root_mm);
    const double c = b.chord_root_mm + s * (b.chord_tip_mm - b.chord_root_mm);
    const double thick = b.thickness_root_mm + s * (b.thickness_tip_mm - b.thickness_root_mm);
    const double g = b.stagger_root_rad + s * (b.stagger_tip_rad - b.stagger_root_rad);
    const double r1 = b.le_radius_mm * c / b.chord_root_mm, r2 = b.te_radius_mm * c / b.chord_root_mm;
    const double k = c - r1 - r2, th = b.camber_rad, radius = k / (2.0 * std::sin(th / 2.0));
    p -= (z - b.z_root_mm) * Vector2d(std::tan(b.lean_x_rad), std::tan(b.lean_y_rad));
    const Vector2d q(std::cos(g) * p.x() + std::sin(g) * p.y(), -std::sin(g) * p.x() + std::cos(g) * p.y());
    double best = 1e9;
    for (int i = 0; i <= 20000; ++i) {
        const double t = i / 20000.0, a = (t - 0.5) * th;
        const Vector2d m(radius * std::sin(a), radius * (std::cos(a) - std::cos(th / 2.0)));
        const double rho = r1 * (1 - t) + r2 * t +
                           (thick / 2 - (r1 + r2) / 2) * (2 * t * (1 - t) + 27.0 / 8.0 * t * (1 - t) * (1 - t));
        best = std::min(best, (q - m).norm() - rho);
    }
    return best;
}

TEST(ParametricNominal, LiesOnTheEnvelopeOfTheCircles) {
    const auto blade = test_blade();
    const auto nominal = parametric(blade);
    for (const double z : {0.0, 23.0, 60.0}) {
        const auto contour = cut(*nominal, z);
        EXPECT_GE(contour.points.size(), 1200U);
        EXPECT_GT(signed_area(contour.points), 0.0);
        double worst = 0.0;
        for (std::size_t i = 0; i < contour.points.size(); i += 7) {
            worst = std::max(worst, std::abs(distance_to_circles(blade, z, contour.points[i])));
        }
        EXPECT_LT(worst, 1e-6) << z;
    }
}

TEST(ParametricNominal, SamplesEdgesDenselyAndSaysItsLean) {
    auto blade = test_blade();
    blade.te_radius_mm = 0.1;
    const auto contour = cut(*parametric(blade), 30.0);
    double worst_turn = 0.0;
    for (std::size_t i = 0; i < contour.points.size(); ++i) {
        const std::size_t n = contour.points.size();
        const Vector2d a = contour.points[(i + 1) % n] - contour.points[i],
                       b = contour.points[(i + 2) % n] - contour.points[(i + 1) % n];
        worst_turn = std::max(worst_turn, std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b))));
    }
    EXPECT_LT(worst_turn, 0.2);
    blade = test_blade();
    blade.stagger_tip_rad = blade.stagger_root_rad;
    blade.chord_tip_mm = blade.chord_root_mm;
    blade.thickness_tip_mm = blade.thickness_root_mm;
    // A sheared prism leans most where its normal points along the shear.
    const double shear = std::hypot(std::tan(blade.lean_x_rad), std::tan(blade.lean_y_rad));
    EXPECT_NEAR(cut(*parametric(blade), 30.0).lean_rad, std::atan(shear), 1e-4);
}

TEST(ParametricNominal, RefusesImpossibleNumbersAndHeights) {
    auto blade = test_blade();
    blade.thickness_root_mm = 60.0;
    const auto nominal = parametric_nominal(blade);
    ASSERT_FALSE(nominal);
    EXPECT_EQ(nominal.error().code, core::ErrorCode::config_invalid);
    const auto outside = parametric(test_blade())->cut(61.0);
    ASSERT_FALSE(outside);
    EXPECT_EQ(outside.error().code, core::ErrorCode::plan_invalid);
    EXPECT_EQ(outside.error().message, "z = 61.000 mm lies outside the nominal (0.000 mm to 60.000 mm)");
}

std::vector<Vector2d> every(const std::vector<Vector2d>& points, std::size_t count) {
    std::vector<Vector2d> chosen;
    for (std::size_t i = 0; i < count; ++i)
        chosen.push_back(points[i * points.size() / count]);
    return chosen;
}

PointSection section_at(double z, const std::vector<Vector2d>& points) {
    PointSection section;
    section.name = core::fixed(z, 1);
    for (const auto& p : points)
        section.points_mm.emplace_back(p.x(), p.y(), z);
    return section;
}

TEST(SectionsNominal, UsesPlanarSectionsAsTheyAreAndLoftsBetweenThem) {
    const auto truth = parametric(test_blade());
    std::vector<PointSection> sections;
    for (const double z : {0.0, 15.0, 30.0, 45.0, 60.0}) {
        auto points = every(cut(*truth, z).points, z == 15.0 ? 500 : 700);  // different counts: resampled by arc length
        if (z == 30.0) std::rotate(points.begin(), points.begin() + 100, points.end());
        if (z == 45.0) std::reverse(points.begin(), points.end());
        sections.push_back(section_at(z, points));
    }
    std::swap(sections[1], sections[3]);
    const auto nominal = sections_nominal(sections, Span::automatic);
    ASSERT_TRUE(nominal) << nominal.error().text();
    EXPECT_EQ(cut(**nominal, 15.0004).points.size(), 500U);
    EXPECT_LT(largest_distance(cut(**nominal, 45.0).points, cut(*truth, 45.0).points), 1e-3);
    const auto between = cut(**nominal, 22.0);
    EXPECT_GE(between.points.size(), 1200U);
    EXPECT_LT(largest_distance(between.points, cut(*truth, 22.0).points), 0.01);
    EXPECT_NEAR(between.lean_rad, cut(*truth, 22.0).lean_rad, 0.01);
    EXPECT_NE((*nominal)->cut(60.2).error().message.find("(0.000 mm to 60.000 mm)"), std::string::npos);
}

/// Points at equal steps of the parametric blade's own contour, begun a part of a step behind one of them.
std::vector<Vector2d> begun(const Nominal& truth, double z, std::size_t count, double at) {
    const auto all = cut(truth, z).points;
    std::vector<Vector2d> chosen;
    for (std::size_t i = 0; i < count; ++i) {
        const double place =
            static_cast<double>(all.size()) * (static_cast<double>(i) + at) / static_cast<double>(count);
        const auto k = static_cast<std::size_t>(place);
        const double w = place - std::floor(place);
        chosen.push_back((1.0 - w) * all[k % all.size()] + w * all[(k + 1) % all.size()]);
    }
    return chosen;
}

TEST(SectionsNominal, OfOneNumberOfPointsMayBeginAtDifferentPlaces) {
    const auto truth = parametric(test_blade());
    const auto lofted = [&](const std::vector<double>& starts) {
        std::vector<PointSection> sections;
        for (std::size_t k = 0; k < starts.size(); ++k) {
            const double z = 15.0 * static_cast<double>(k);
            sections.push_back(section_at(z, begun(*truth, z, 700, starts[k])));
        }
        const auto nominal = sections_nominal(sections, Span::z);
        EXPECT_TRUE(nominal) << nominal.error().text();
        return *nominal;
    };
    const auto together = lofted({0.0, 0.0, 0.0, 0.0, 0.0});
    // The same points in another order, and points that lie between those of the neighbours.
    const auto same_points = lofted({0.0, 300.0, 1.0, 699.0, 120.0});
    const auto other_points = lofted({0.0, 300.4, 1.0, 20.7, 650.5});
    for (const double z : {7.0, 22.0, 38.0, 53.0}) {
        const auto points = cut(*truth, z).points;
        const double off = largest_distance(cut(*together, z).points, points);
        EXPECT_LT(off, 0.01) << z;
        EXPECT_LT(largest_distance(cut(*same_points, z).points, points), 0.01) << z;
        EXPECT_LT(largest_distance(cut(*other_points, z).points, points), 0.01) << z;
        EXPECT_NEAR(cut(*other_points, z).lean_rad, cut(*truth, z).lean_rad, 0.01) << z;
    }
}

/// Files repeat the first point at the end, and round it: some sections end 20 nm off, some exactly where they began.
/// All have as many points then. NASA's Rotor 37 was joined by arc length instead of point by point, 88 um off.
TEST(SectionsNominal, OfClosingPointsRoundingMakesNoDifference) {
    const auto truth = parametric(test_blade());
    const auto lofted = [&](double closing_mm, bool repeated) {
        std::vector<PointSection> sections;
        for (std::size_t k = 0; k < 5; ++k) {
            const double z = 15.0 * static_cast<double>(k);
            auto points = begun(*truth, z, 200, 0.0);
            if (repeated) points.push_back(points.front() + Vector2d(k % 2 == 0 ? closing_mm : 0.0, 0.0));
            if (repeated) points.insert(points.begin() + 50, points[50] + Vector2d(0.0, k % 2 == 0 ? closing_mm : 0.0));
            sections.push_back(section_at(z, points));
        }
        return sections_nominal(sections, Span::z).value();
    };
    const auto once = lofted(0.0, false), twice = lofted(2e-5, true);
    for (const double z : {7.0, 22.0, 38.0, 53.0})
        EXPECT_LT(largest_distance(cut(*twice, z).points, cut(*once, z).points), 1e-4) << z;
}

TEST(SectionsNominal, CutsSectionsOnCurvedSurfacesOfAnySpan) {
    const auto truth = parametric(test_blade());
    std::vector<PointSection> sections;
    constexpr std::size_t count = 240;
    for (int k = 0; k < 7; ++k) {
        PointSection section;
        section.name = std::to_string(k);
        for (std::size_t i = 0; i < count; ++i) {
            const double z = 5.0 + 8.0 * k + 0.5 * std::sin(2.0 * std::numbers::pi * static_cast<double>(i) / count);
            const auto contour = cut(*truth, z).points;
            const auto& p = contour[i * contour.size() / count];
            section.points_mm.emplace_back(z, p.x(), p.y());
        }
        sections.push_back(section);
    }
    const auto nominal = sections_nominal(sections, Span::automatic);
    ASSERT_TRUE(nominal) << nominal.error().text();
    EXPECT_GT((*nominal)->z_low_mm(), 5.0);
    EXPECT_LT(largest_distance(cut(**nominal, 30.0).points, cut(*truth, 30.0).points), 5e-3);
    EXPECT_FALSE((*nominal)->cut((*nominal)->z_low_mm() - 0.1));
}

TEST(SectionsNominal, RefusesBrokenSections) {
    const auto points = every(cut(*parametric(test_blade()), 20.0).points, 300);
    const auto message = [](std::vector<PointSection> sections) {
        const auto nominal = sections_nominal(std::move(sections), Span::z);
        return nominal ? std::string() : nominal.error().message;
    };
    EXPECT_NE(message({section_at(1.0, points), section_at(1.0, points)}).find("same height, z = 1.000 mm"),
              std::string::npos);
    EXPECT_NE(message({section_at(1.0, {points.begin(), points.begin() + 200})}).find("is open"), std::string::npos);
    EXPECT_NE(message({section_at(1.0, {points.begin(), points.begin() + 4})}).find("no closed contour"),
              std::string::npos);
    auto tilted = section_at(1.0, points);
    tilted.points_mm[0].z() += 0.1;
    EXPECT_NE(message({tilted}).find("give at least two"), std::string::npos);
    EXPECT_EQ(message({section_at(1.0, points)}), "");
}

TEST(SectionsNominal, CutsTheRealCompressorBlades) {
    for (const std::string name : {"1_Rotor1_Blade.crv", "2_Stator1_Vane.crv", "7_Rotor4_Blade.crv"}) {
        const std::string file = real_data("hannover-4ac/" + name);
        if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
        NominalSpec spec;
        spec.kind = NominalKind::sections;
        spec.files = {file};
        const auto nominal = load_nominal(spec);
        ASSERT_TRUE(nominal) << nominal.error().text();
        const double low = (*nominal)->z_low_mm(), high = (*nominal)->z_high_mm();
        EXPECT_GT(high - low, 45.0);
        for (int i = 0; i < 10; ++i) {
            const auto contour = cut(**nominal, low + (high - low) * i / 9.0);
            EXPECT_GE(contour.points.size(), 1200U);
            double widest = 0.0;
            for (std::size_t k = 1; k < contour.points.size(); ++k)
                widest = std::max(widest, (contour.points[k] - contour.points[k - 1]).norm());
            EXPECT_LT(widest, 0.2) << name << " cut " << i;
            EXPECT_LT(contour.lean_rad, 1.0);
        }
    }
}

/// One blade below a height and another above, whose other edge is the blunter one.
class TwoBlades final : public Nominal {
  public:
    TwoBlades(double change_mm, double te_above_mm) : change_mm_(change_mm) {
        auto blade = test_blade();
        below_ = parametric(blade);
        blade.te_radius_mm = te_above_mm;
        above_ = parametric(blade);
    }
    core::Result<NominalContour> cut(double z_mm) const override {
        return (z_mm < change_mm_ ? below_ : above_)->cut(z_mm);
    }
    double z_low_mm() const override { return below_->z_low_mm(); }
    double z_high_mm() const override { return below_->z_high_mm(); }

  private:
    double change_mm_;
    std::shared_ptr<const Nominal> below_, above_;
};

/// Where the chosen LE lies: left (-1) or right (1) at the lowest, a middle and the highest place.
std::array<int, 3> leading_sides(const Nominal& nominal) {
    std::array<int, 3> sides{};
    for (std::size_t k = 0; k < sides.size(); ++k) {
        const double share = 0.05 + 0.45 * static_cast<double>(k);
        const auto contour = cut(nominal, nominal.z_low_mm() + share * (nominal.z_high_mm() - nominal.z_low_mm()));
        const auto section = fitting::analyse_nominal(contour.points, edge_hints(NominalSpec{}, contour));
        EXPECT_TRUE(section);
        sides[k] = section->le_point().x() < section->te_point().x() ? -1 : 1;
    }
    return sides;
}

TEST(OneLeadingEdge, IsTheSameAtAllHeights) {
    const double le_mm = test_blade().le_radius_mm, low_mm = parametric(test_blade())->z_low_mm(),
                 high_mm = parametric(test_blade())->z_high_mm();
    ASSERT_GT(le_mm, test_blade().te_radius_mm);
    const auto at = [&](double share) { return low_mm + share * (high_mm - low_mm); };
    const auto mostly_left = std::make_shared<TwoBlades>(at(0.7), 1.1 * le_mm);
    EXPECT_EQ(leading_sides(*mostly_left), (std::array{-1, -1, 1})) << "each height by itself";
    EXPECT_EQ(leading_sides(*with_one_leading_edge(mostly_left)), (std::array{-1, -1, -1}));
    const auto mostly_right = std::make_shared<TwoBlades>(at(0.2), 2.0 * le_mm);
    EXPECT_EQ(leading_sides(*mostly_right), (std::array{-1, 1, 1})) << "each height by itself";
    EXPECT_EQ(leading_sides(*with_one_leading_edge(mostly_right)), (std::array{1, 1, 1}));
}

/// By itself, the LE of this rotor would be the other edge from 140 mm on.
TEST(OneLeadingEdge, OfARealCompressorBlade) {
    NominalSpec spec;
    spec.kind = NominalKind::sections;
    spec.files = {real_data("hannover-4ac/1_Rotor1_Blade.crv")};
    if (!std::filesystem::exists(spec.files[0])) GTEST_SKIP() << spec.files[0] << " is not there";
    const auto nominal = load_nominal(spec);
    ASSERT_TRUE(nominal) << nominal.error().text();
    EXPECT_EQ(leading_sides(**nominal), (std::array{1, 1, 1}));
}

TEST(MeshNominal, MatchesTheKnownCutsOfTheEngineBlade) {
    const std::string file = real_data("engine-blade/engine-blade.ply");
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    NominalSpec spec;
    spec.kind = NominalKind::mesh;
    spec.files = {file};
    const auto nominal = load_nominal(spec);
    ASSERT_TRUE(nominal) << nominal.error().text();
    for (const std::string z : {"300.0", "345.0", "370.0"}) {
        const auto known = read_points(real_data("engine-blade/section_z" + z + ".csv"));
        ASSERT_TRUE(known) << known.error().text();
        std::vector<Vector2d> polygon;
        for (const auto& p : known->front().points_mm)
            polygon.emplace_back(p.head<2>());
        const auto contour = cut(**nominal, std::stod(z));
        EXPECT_LT(largest_distance(contour.points, polygon), 1e-3);
        EXPECT_LT(largest_distance(polygon, contour.points), 3e-3);  // corners nearer than 2 um are one
        EXPECT_GT(signed_area(contour.points), 0.0);
    }
}

/// A square prism from z = 0 to 2 with vertices also at z = 1.
TriangleMesh prism() {
    TriangleMesh mesh;
    for (const double z : {0.0, 1.0, 2.0}) {
        for (const auto& [x, y] : {std::pair{0.0, 0.0}, {4.0, 0.0}, {4.0, 3.0}, {0.0, 3.0}})
            mesh.vertices.emplace_back(x, y, z);
    }
    for (std::uint32_t layer = 0; layer < 2; ++layer) {
        for (std::uint32_t i = 0; i < 4; ++i) {
            const std::uint32_t a = 4 * layer + i, b = 4 * layer + (i + 1) % 4;
            mesh.triangles.push_back({a, b, b + 4});
            mesh.triangles.push_back({a, b + 4, a + 4});
        }
    }
    for (const std::uint32_t base : {0U, 8U}) {
        mesh.triangles.push_back({base, base + 1, base + 2});
        mesh.triangles.push_back({base, base + 2, base + 3});
    }
    return mesh;
}

TEST(MeshNominal, CutsThroughVerticesAndRefusesHoles) {
    const auto nominal = mesh_nominal(prism(), Span::z);
    ASSERT_TRUE(nominal);
    for (const double z : {0.5, 1.0, 2.0}) {
        const auto contour = cut(**nominal, z);
        EXPECT_NEAR(signed_area(contour.points), 12.0, 1e-9) << z;
        EXPECT_NEAR(contour.lean_rad, 0.0, z == 2.0 ? 2.0 : 1e-12);  // in the top face the normal is the span itself
    }
    auto open = prism();
    open.triangles.erase(open.triangles.begin() + 2);
    const auto broken = (*mesh_nominal(open, Span::z))->cut(0.5);
    ASSERT_FALSE(broken);
    EXPECT_EQ(broken.error().code, core::ErrorCode::input_invalid);
    EXPECT_NE(broken.error().message.find("the mesh is open near x = 4.000 mm"), std::string::npos)
        << broken.error().message;
    EXPECT_EQ(nominal.value()->cut(2.5).error().code, core::ErrorCode::plan_invalid);
    const auto turned = mesh_nominal(prism(), Span::x);  // (x, y, z) -> (y, z, x): 4 mm high now
    EXPECT_NEAR(signed_area(cut(**turned, 1.7).points), 6.0, 1e-9);
}

}  // namespace
}  // namespace cmm::acquisition
