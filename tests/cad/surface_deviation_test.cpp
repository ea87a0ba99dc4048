// SPDX-License-Identifier: Apache-2.0
// Deviations of a part from the surface of its STEP file, against displacements along the normal that are known.
#include "acquisition/surface_deviation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "acquisition/section_figures.hpp"
#include "acquisition/section_setup.hpp"
#include "tests/acquisition/temp_folder.hpp"
#include "tests/cad/elliptic_body.hpp"

namespace cmm::acquisition {
namespace {

using cad::test::EllipticBody;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// A point of the body with its outward normal, by the formulas of the body alone.
struct SurfacePoint {
    Vector3d position, normal;
};
SurfacePoint surface_at(const EllipticBody& body, double t, double z_mm) {
    const auto place = [t](const cad::test::Ellipse& e) {
        return Vector3d(e.centre_mm + std::cos(t) * e.along_mm + std::sin(t) * e.across_mm);
    };
    const auto e = body.at(z_mm);
    const Vector3d round = -std::sin(t) * e.along_mm + std::cos(t) * e.across_mm;
    return {place(e), round.cross(place(body.top) - place(body.bottom)).normalized()};
}

/// The part's place at this t in the plane z: the body, displaced by d along its normal.
SurfacePoint displaced(const EllipticBody& body, double t, double z_mm, double d) {
    double from = z_mm;
    SurfacePoint s = surface_at(body, t, from);
    for (int step = 0; step < 50; ++step) {
        from = z_mm - d * s.normal.z();
        s = surface_at(body, t, from);
    }
    return {s.position + d * s.normal, s.normal};
}

class SurfaceDeviations : public testing::Test {
  protected:
    void SetUp() override {
        const auto file = folder_.path("body.step");
        write_step_file(file, body_);
        NominalSpec spec;
        spec.kind = NominalKind::step;
        spec.files = {file};
        auto nominal = load_nominal(spec);
        ASSERT_TRUE(nominal) << nominal.error().text();
        nominal_ = *nominal;
    }
    SectionSetup setup(double z_mm, NominalKind kind = NominalKind::step) const {
        PartFile part;
        part.nominal.kind = kind;
        part.stylus.radius_mm = 0.1;
        auto setup = make_section_setup(part, nominal_.get(), 0, z_mm);
        EXPECT_TRUE(setup) << setup.error().text();
        return std::move(*setup);
    }
    /// The section of a part whose surface is the body's, displaced by d(t).
    template <class Displacement>
    SectionResult measured(double z_mm, Displacement&& d, std::vector<double>& truth) const {
        SectionResult section;
        section.z_mm = z_mm;
        section.fit.emplace();
        constexpr int count = 720;
        for (int i = 0; i < count; ++i) {
            const double t = 2.0 * std::numbers::pi * i / count;
            const SurfacePoint p = displaced(body_, t, z_mm, d(t));
            fitting::ContourPoint point;
            point.position_mm = p.position.head<2>();
            point.normal = p.normal.head<2>().normalized();
            section.fit->contour.push_back(point);
            truth.push_back(d(t));
        }
        return section;
    }

    TempFolder folder_;
    EllipticBody body_;
    std::shared_ptr<const Nominal> nominal_;
};

TEST_F(SurfaceDeviations, AreTheDisplacementsAlongTheNormal) {
    const auto waves = [](double t) { return 0.030 + 0.020 * std::sin(3.0 * t); };
    const auto thin = [](double) { return -0.040; };
    double steepest = 0.0;
    const auto check = [&](double z_mm, auto&& d) {
        const auto own = setup(z_mm);
        ASSERT_TRUE(own.nominal && own.nominal->surface);
        std::vector<double> truth;
        auto section = measured(z_mm, d, truth);
        section.nominal_surface = own.nominal->surface;
        section.deviation_mm = own.nominal->reference.compare(section.fit->contour);
        const auto found = surface_deviations(section);
        ASSERT_EQ(found.size(), truth.size());
        double sum = 0.0, true_sum = 0.0;
        for (std::size_t i = 0; i < found.size(); ++i) {
            ASSERT_TRUE(found[i]) << "z " << z_mm << ", point " << i;
            EXPECT_NEAR(*found[i], truth[i], 1e-4) << "z " << z_mm << ", point " << i;
            sum += *found[i];
            true_sum += truth[i];
            steepest = std::max(steepest, std::abs(*section.deviation_mm[i] - truth[i]));
        }
        EXPECT_NEAR(sum, true_sum, 1e-4 * double(found.size()));
    };
    for (const double z_mm : {12.0, 35.0, 58.0}) {
        check(z_mm, waves);
        check(z_mm, thin);
    }
    EXPECT_GT(steepest, 3e-4) << "the deviation in the plane is not that along the normal";
}

TEST_F(SurfaceDeviations, FollowTheAlignment) {
    const auto own = setup(35.0);
    std::vector<double> truth;
    auto section = measured(
        35.0, [](double) { return 0.020; }, truth);
    section.deviation_mm = own.nominal->reference.compare(section.fit->contour);
    section.nominal_surface = own.nominal->surface;
    section.alignment.motion.turn_rad = 0.01;
    section.alignment.motion.about_mm = Vector2d(3.0, 4.0);
    section.alignment.motion.shift_mm = Vector2d(0.5, -0.3);
    const Eigen::Rotation2Dd turn(0.01);
    for (auto& point : section.fit->contour) {
        point.position_mm = turn * (point.position_mm - Vector2d(3.0, 4.0)) + Vector2d(3.5, 3.7);
        point.normal = turn * point.normal;
    }
    const auto found = surface_deviations(section);
    ASSERT_EQ(found.size(), truth.size());
    for (std::size_t i = 0; i < found.size(); ++i)
        EXPECT_NEAR(found[i].value_or(1.0), 0.020, 1e-4);
}

TEST_F(SurfaceDeviations, AreDrawn) {
    const auto own = setup(35.0);
    std::vector<double> truth;
    auto section = measured(
        35.0, [](double) { return 0.030; }, truth);
    double around = 0.0;
    for (std::size_t i = 0; i < section.fit->contour.size(); ++i) {
        auto& points = section.fit->contour;
        if (i > 0) around += (points[i].position_mm - points[i - 1].position_mm).norm();
        points[i].arc_length_mm = around;
    }
    section.fit->te_point_mm = section.fit->contour[360].position_mm;
    section.deviation_mm = own.nominal->reference.compare(section.fit->contour);
    PartResult part;
    part.sections.push_back(section);
    const auto judged = judge_fit(section, *section.fit, own);
    EXPECT_EQ(judged.nominal_surface, own.nominal->surface);
    const auto in_plane = map_figure(part);
    EXPECT_EQ(in_plane.find("nominal surface"), std::string::npos);
    part.sections[0].nominal_surface = section.nominal_surface = own.nominal->surface;
    const auto picture = map_figure(part);
    EXPECT_NE(picture.find("distance from the nominal surface"), std::string::npos);

    // Without a surface there are none.
    auto flat = section;
    flat.nominal_surface.reset();
    EXPECT_TRUE(surface_deviations(flat).empty());
    // Where the ball does not reach the nominal there is none either, and nothing is compared without deviations.
    section.deviation_mm[5].reset();
    EXPECT_FALSE(surface_deviations(section)[5]);
    section.deviation_mm.clear();
    EXPECT_TRUE(surface_deviations(section).empty());
}

}  // namespace
}  // namespace cmm::acquisition
