// SPDX-License-Identifier: Apache-2.0
// STEP files as nominals, against bodies whose cuts can be written down.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "acquisition/nominal.hpp"
#include "fitting/closed_curve.hpp"
#include "tests/acquisition/temp_folder.hpp"
#include "tests/cad/elliptic_body.hpp"

namespace cmm::acquisition {
namespace {

using cad::test::Content;
using cad::test::EllipticBody;
using core::ErrorCode;

NominalSpec step_spec(const std::string& file, const std::string& solid = "", Span span = Span::automatic) {
    NominalSpec spec;
    spec.kind = NominalKind::step;
    spec.files = {file};
    spec.solid = solid;
    spec.span = span;
    return spec;
}

class StepNominals : public testing::Test {
  protected:
    std::string written(Content content = Content::solid, const char* unit = "MM") {
        write_step_file(file_, body_, content, unit);
        return file_;
    }
    std::string text(const std::string& content) { return folder_.write("text.step", content); }
    /// Points of the contour on the ellipse; and the spline through them, which is what the rest of the program sees.
    void expect_the_ellipse(const Nominal& nominal, double z_mm) const {
        const auto contour = nominal.cut(z_mm);
        ASSERT_TRUE(contour) << contour.error().text();
        double worst_mm = 0.0, between_mm = 0.0;
        for (const auto& point : contour->points)
            worst_mm = std::max(worst_mm, std::abs(body_.off_mm(point, z_mm)));
        const auto curve = fitting::ClosedCurve::through(contour->points);
        ASSERT_TRUE(curve);
        const std::size_t looks = 3 * contour->points.size();
        for (std::size_t i = 0; i < looks; ++i) {
            const double s = curve->length() * (static_cast<double>(i) + 0.5) / static_cast<double>(looks);
            between_mm = std::max(between_mm, std::abs(body_.off_mm(curve->position(s), z_mm)));
        }
        EXPECT_LT(worst_mm, 1e-7) << "z " << z_mm;
        EXPECT_LT(between_mm, 1e-4) << "z " << z_mm;
    }
    void expect_refused(const NominalSpec& spec, ErrorCode code, const std::string& said) const {
        const auto nominal = load_nominal(spec);
        ASSERT_FALSE(nominal);
        EXPECT_EQ(nominal.error().code, code);
        EXPECT_NE(nominal.error().message.find(said), std::string::npos) << nominal.error().text();
    }

    TempFolder folder_;
    std::string file_ = folder_.path("body.step");
    EllipticBody body_;
};

TEST_F(StepNominals, CutsAreOnTheBody) {
    const auto nominal = load_nominal(step_spec(written()));
    ASSERT_TRUE(nominal) << nominal.error().text();
    EXPECT_NEAR((*nominal)->z_low_mm(), 5.0, 1e-6);
    EXPECT_NEAR((*nominal)->z_high_mm(), 65.0, 1e-6);
    for (const double z_mm : {5.0, 5.001, 12.0, 23.7, 35.0, 51.25, 64.9, 65.0})
        expect_the_ellipse(**nominal, z_mm);
}

TEST_F(StepNominals, LeansAreThoseOfTheSurface) {
    const auto nominal = load_nominal(step_spec(written()));
    ASSERT_TRUE(nominal) << nominal.error().text();
    const double z_mm = 30.0;
    const auto contour = (*nominal)->cut(z_mm).value();
    const auto ellipse = body_.at(z_mm);
    Eigen::Matrix2d axes;
    axes << ellipse.along_mm.head<2>(), ellipse.across_mm.head<2>();
    double largest = 0.0;
    for (std::size_t i = 0; i < contour.points.size(); ++i) {
        const Eigen::Vector2d unit = axes.inverse() * (contour.points[i] - ellipse.centre_mm.head<2>());
        const double truth = body_.lean_rad(z_mm, std::atan2(unit.y(), unit.x()));
        EXPECT_NEAR(contour.leans_rad.at(i), truth, 2e-3);
        largest = std::max(largest, std::abs(truth));
    }
    EXPECT_NEAR(contour.lean_rad, largest, 2e-3);
}

TEST_F(StepNominals, InchesBecomeMillimetres) {
    const auto nominal = load_nominal(step_spec(written(Content::solid, "INCH")));
    std::ifstream in(file_);
    const std::string content((std::istreambuf_iterator<char>(in)), {});
    ASSERT_NE(content.find("INCH"), std::string::npos);
    ASSERT_TRUE(nominal) << nominal.error().text();
    expect_the_ellipse(**nominal, 40.0);
}

TEST_F(StepNominals, AnyAxisIsTheSpan) {
    // Turned the other way before, so that the span lies along y, or x.
    const auto turned = [](const EllipticBody& body, const Eigen::Matrix3d& turn) {
        EllipticBody other = body;
        for (auto* ellipse : {&other.bottom, &other.top}) {
            for (auto* vector : {&ellipse->centre_mm, &ellipse->along_mm, &ellipse->across_mm})
                *vector = turn * *vector;
        }
        return other;
    };
    Eigen::Matrix3d cycle;
    cycle << 0, 1, 0, 0, 0, 1, 1, 0, 0;  // (x, y, z) -> (y, z, x)
    write_step_file(file_, turned(body_, cycle));
    const auto along_y = load_nominal(step_spec(file_, "", Span::y));
    ASSERT_TRUE(along_y) << along_y.error().text();
    expect_the_ellipse(**along_y, 20.0);
    write_step_file(file_, turned(body_, cycle * cycle));
    const auto along_x = load_nominal(step_spec(file_, "", Span::x));
    ASSERT_TRUE(along_x) << along_x.error().text();
    expect_the_ellipse(**along_x, 20.0);
}

TEST_F(StepNominals, FacesWithoutASolidWillDoAlsoWhereTheyMeet) {
    const auto nominal = load_nominal(step_spec(written(Content::stacked_faces)));
    ASSERT_TRUE(nominal) << nominal.error().text();
    for (const double z_mm : {10.0, 34.999, 35.0, 35.001, 60.0})
        expect_the_ellipse(**nominal, z_mm);
}

TEST_F(StepNominals, OneOfSeveralSolidsIsChosen) {
    const std::string file = written(Content::two_solids);
    expect_refused(step_spec(file), ErrorCode::input_invalid, "holds 2 solids; choose one by [nominal] solid: 1");
    expect_refused(step_spec(file, "3"), ErrorCode::input_invalid, "has no solid \"3\"");
    const auto first = load_nominal(step_spec(file, "1"));
    ASSERT_TRUE(first) << first.error().text();
    expect_the_ellipse(**first, 40.0);
    const auto second = load_nominal(step_spec(file, "2"));
    ASSERT_TRUE(second) << second.error().text();
    for (auto* ellipse : {&body_.bottom, &body_.top})
        ellipse->centre_mm.y() += 100.0;
    expect_the_ellipse(**second, 40.0);
}

TEST_F(StepNominals, BrokenFilesAreNamed) {
    expect_refused(step_spec(folder_.path("absent.step")), ErrorCode::input_missing, "absent.step");
    expect_refused(step_spec(text("")), ErrorCode::input_invalid, "is empty");
    expect_refused(step_spec(text("x,y,z\n1,2,3\n")), ErrorCode::input_invalid, "is not a STEP file");
    expect_refused(step_spec(text("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n"
                                  "FILE_NAME('','',(''),(''),'','','');\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\n"
                                  "DATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\nEND-ISO-10303-21;\n")),
                   ErrorCode::input_invalid, "holds neither a solid nor a face");
    const std::string whole = written();
    const auto size = std::filesystem::file_size(whole);
    for (const auto share : {0.05, 0.3, 0.6, 0.9}) {
        write_step_file(whole, body_);
        std::filesystem::resize_file(whole, static_cast<std::uintmax_t>(share * static_cast<double>(size)));
        const auto nominal = load_nominal(step_spec(whole));
        EXPECT_FALSE(nominal) << share;
        if (nominal) continue;
        EXPECT_EQ(nominal.error().code, ErrorCode::input_invalid);
        EXPECT_NE(nominal.error().message.find("body.step"), std::string::npos);
    }
}

TEST_F(StepNominals, PlanesThatMissAndPartsThatGapeAreNamed) {
    const auto nominal = load_nominal(step_spec(written()));
    ASSERT_TRUE(nominal) << nominal.error().text();
    for (const double z_mm : {4.9, 65.1}) {
        const auto missed = (*nominal)->cut(z_mm);
        ASSERT_FALSE(missed);
        EXPECT_EQ(missed.error().code, ErrorCode::plan_invalid);
        EXPECT_NE(missed.error().message.find("(5.000 mm to 65.000 mm)"), std::string::npos) << missed.error().text();
    }
    const auto gaping = load_nominal(step_spec(written(Content::gaping_faces)));
    ASSERT_TRUE(gaping) << gaping.error().text();
    const auto open = (*gaping)->cut(30.0);
    ASSERT_FALSE(open);
    EXPECT_EQ(open.error().code, ErrorCode::input_invalid);
    EXPECT_NE(open.error().message.find("cut at z = 30.000 mm: the part is open near x = "), std::string::npos)
        << open.error().text();
}

}  // namespace
}  // namespace cmm::acquisition
