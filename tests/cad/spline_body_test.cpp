// SPDX-License-Identifier: Apache-2.0
// B-spline bodies written as STEP and STL, read back, against the net's own evaluation.
#include "cad/spline_body.hpp"

#include <gtest/gtest.h>

#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <Eigen/Geometry>
#include <GProp_GProps.hxx>
#include <STEPControl_Reader.hxx>
#include <TopExp_Explorer.hxx>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>

#include "acquisition/triangle_mesh.hpp"
#include "cad/step_part.hpp"
#include "fitting/bspline.hpp"
#include "fitting/closed_curve.hpp"
#include "tests/acquisition/temp_folder.hpp"

namespace cmm::cad {
namespace {

using acquisition::TempFolder;
using core::ErrorCode;
using Curve = fitting::BSpline<3>;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;
constexpr double span_mm = 60.0;

std::vector<double> even_knots(std::size_t count, double from) {
    std::vector<double> knots;
    for (std::size_t i = 0; i < count; ++i)
        knots.push_back(from + static_cast<double>(i));
    return knots;
}

/// Round a thin blade in the chord frame, counter-clockwise: end circles of these radii, straight sides between.
std::vector<Vector2d> outline(double chord_mm, double le_radius_mm, double te_radius_mm) {
    constexpr int on_end = 24, on_side = 40;
    const double axis_mm = chord_mm - le_radius_mm - te_radius_mm;
    const double open = std::asin((le_radius_mm - te_radius_mm) / axis_mm);  // of the sides to the chord
    std::vector<Vector2d> points;
    const auto end = [&](double x, double radius, double from, double turn) {
        for (int k = 0; k <= on_end; ++k) {
            const double angle = from + turn * k / on_end;
            points.emplace_back(x + radius * std::cos(angle), radius * std::sin(angle));
        }
    };
    const auto side = [&](const Vector2d& from, const Vector2d& to) {
        for (int k = 1; k < on_side; ++k)  // closer together near the ends
            points.push_back(from + (to - from) * 0.5 * (1.0 - std::cos(pi * k / on_side)));
    };
    const double le = 0.5 * pi - open;
    end(-0.5 * axis_mm, le_radius_mm, le, 2.0 * (pi - le));
    const Vector2d low_te(0.5 * axis_mm + te_radius_mm * std::cos(-le), te_radius_mm * std::sin(-le));
    const Vector2d high_le = points.front(), low_le = points.back();
    side(low_le, low_te);
    end(0.5 * axis_mm, te_radius_mm, -le, 2.0 * le);
    side(points.back(), high_le);
    return points;
}

/// A twisted, tapered blade whose trailing edge has 0.1 mm at the root; z runs linearly with v.
SplineNet blade() {
    constexpr std::size_t rows = 9;
    SplineNet net;
    for (std::size_t j = 0; j < rows; ++j) {
        const double share = static_cast<double>(j) / (rows - 1);
        const Eigen::Rotation2Dd twist(0.2 + 0.5 * share);
        for (const auto& p : outline(40.0 - 6.0 * share, 0.8, 0.1)) {
            const Vector2d q = twist * p + Vector2d(3.0 * share, -share);
            // Of evenly spaced knots, clamped: the heights that make z linear in v are the knots' means (Greville).
            net.controls.emplace_back(q.x(), q.y(), 0.0);
        }
    }
    net.count_u = net.controls.size() / rows;
    net.knots_u = even_knots(net.count_u + 7, 0.0);
    net.knots_v = {0, 0, 0};
    for (const double knot : even_knots(rows - 2, 0.0))
        net.knots_v.push_back(knot);
    net.knots_v.insert(net.knots_v.end(), 3, net.knots_v.back());
    for (std::size_t j = 0; j < rows; ++j) {
        const double mean = (net.knots_v[j + 1] + net.knots_v[j + 2] + net.knots_v[j + 3]) / 3.0;
        for (std::size_t i = 0; i < net.count_u; ++i)
            net.controls[j * net.count_u + i].z() = span_mm * mean / net.knots_v.back();
    }
    return net;
}

/// The section at this height: its B-spline, blended from the rows.
Curve section(const SplineNet& net, double z_mm) {
    const double v = z_mm / span_mm * net.knots_v.back();
    std::vector<Vector3d> row;
    for (std::size_t i = 0; i < net.count_u; ++i) {
        std::vector<Vector3d> column;
        for (std::size_t k = i; k < net.controls.size(); k += net.count_u)
            column.push_back(net.controls[k]);
        row.push_back(Curve::make(3, net.knots_v, column, false)->position(v));
    }
    return Curve::make(3, net.knots_u, row, true).value();
}

constexpr std::array gauss_nodes{-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831, 0.9061798459386640};
constexpr std::array gauss_weights{0.2369268850561891, 0.4786286704990365, 0.5688888888888889, 0.4786286704990365,
                                   0.2369268850561891};

/// Green's theorem, span by span; the integrand has degree 5.
double area_mm2(const Curve& curve) {
    double area = 0.0;
    for (double from = curve.front(); from < curve.back() - 0.5; from += 1.0) {
        for (std::size_t k = 0; k < gauss_nodes.size(); ++k) {
            const auto jet = curve.derivatives(from + 0.5 * (1.0 + gauss_nodes.at(k)), 1);
            area += 0.25 * gauss_weights.at(k) * (jet[0].x() * jet[1].y() - jet[0].y() * jet[1].x());
        }
    }
    return area;
}

/// The area over the height, knot span by knot span (degree 6 in v).
double volume_mm3(const SplineNet& net) {
    const double spans = net.knots_v.back();
    double volume = 0.0;
    for (double from = 0.0; from < spans - 0.5; from += 1.0) {
        for (std::size_t k = 0; k < gauss_nodes.size(); ++k) {
            const double v = from + 0.5 * (1.0 + gauss_nodes.at(k));
            volume += 0.5 * gauss_weights.at(k) * span_mm / spans * area_mm2(section(net, v / spans * span_mm));
        }
    }
    return volume;
}

std::string content_of(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

int count_of(const TopoDS_Shape& shape, TopAbs_ShapeEnum kind) {
    int count = 0;
    for (TopExp_Explorer found(shape, kind); found.More(); found.Next())
        ++count;
    return count;
}

TopoDS_Shape read_shape(const std::string& file) {
    STEPControl_Reader reader;
    EXPECT_EQ(reader.ReadFile(file.c_str()), IFSelect_RetDone);
    reader.TransferRoots();
    return reader.OneShape();
}

class SplineBody : public testing::Test {
  protected:
    TempFolder folder_;
    std::string file_ = folder_.path("blade.step");
    SplineNet net_ = blade();
};

TEST_F(SplineBody, IsAValidSolidOfTheRightVolumeInBothSchemas) {
    for (const auto schema : {StepSchema::ap214, StepSchema::ap242}) {
        StepOptions options;
        options.schema = schema;
        options.name = "rotor-1";
        const auto written = write_step(net_, options, file_);
        ASSERT_TRUE(written) << written.error().text();
        const auto text = content_of(file_);
        EXPECT_NE(text.find(schema == StepSchema::ap242 ? "AP242" : "AUTOMOTIVE_DESIGN"), std::string::npos);
        EXPECT_NE(text.find("PRODUCT('rotor-1','rotor-1'"), std::string::npos);
        EXPECT_TRUE(read_step(file_, "rotor-1", 2));
        EXPECT_FALSE(read_step(file_, "rotor-2", 2));
        const auto shape = read_shape(file_);
        EXPECT_TRUE(BRepCheck_Analyzer(shape).IsValid());
        EXPECT_EQ(count_of(shape, TopAbs_SOLID), 1);
        EXPECT_EQ(count_of(shape, TopAbs_FACE), 3);
        GProp_GProps found;
        BRepGProp::VolumeProperties(shape, found, 1e-8);
        const double truth = volume_mm3(net_);
        std::printf("volume %.6f mm3, truth %.6f mm3\n", found.Mass(), truth);
        EXPECT_NEAR(found.Mass(), truth, 1e-5 * truth);
    }
}

TEST_F(SplineBody, ItsCutsAreTheSectionsOfTheNet) {
    ASSERT_TRUE(write_step(net_, {}, file_));
    const auto part = read_step(file_, "", 2);
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_NEAR((*part)->z_low_mm(), 0.0, 1e-6);
    EXPECT_NEAR((*part)->z_high_mm(), span_mm, 1e-6);
    for (const double z_mm : {0.0, 0.5, 13.7, 30.0, 59.9, 60.0}) {
        const auto cut = (*part)->cut(z_mm);
        ASSERT_TRUE(cut) << cut.error().text();
        const auto truth = section(net_, z_mm);
        std::vector<fitting::Vec2> dense;
        for (double u = truth.front(); u < truth.back(); u += 0.05)
            dense.emplace_back(truth.position(u).head<2>());
        const auto curve = fitting::ClosedCurve::through(dense).value();
        double worst_mm = 0.0;
        for (const double t : (*cut)->coarse())
            worst_mm = std::max(worst_mm, curve.closest((*cut)->at(t).position_mm).distance_mm);
        EXPECT_LT(worst_mm, 1e-5) << z_mm;
    }
}

TEST_F(SplineBody, ATrailingEdgeOfATenthOfAMillimetreSurvives) {
    ASSERT_TRUE(write_step(net_, {}, file_));
    const auto cut = read_step(file_, "", 2).value()->cut(20.0);
    ASSERT_TRUE(cut) << cut.error().text();
    const auto truth = section(net_, 20.0);
    // The nose is the place farthest out along the chord; its radius of curvature in the file and in the net.
    const Vector2d chord = Eigen::Rotation2Dd(0.2 + 0.5 / 3.0) * Vector2d::UnitX();
    double nose_t = 0.0, nose_u = truth.front();
    const auto along = [&](const Vector2d& p) { return p.dot(chord); };
    for (double t = 0.0; t < (*cut)->period(); t += 1e-5) {
        if (along((*cut)->at(t).position_mm) > along((*cut)->at(nose_t).position_mm)) nose_t = t;
    }
    for (double u = truth.front(); u < truth.back(); u += 1e-3) {
        if (along(truth.position(u).head<2>()) > along(truth.position(nose_u).head<2>())) nose_u = u;
    }
    EXPECT_LT(((*cut)->at(nose_t).position_mm - truth.position(nose_u).head<2>()).norm(), 1e-4);
    const auto jet = truth.derivatives(nose_u, 2);
    const double radius =
        std::pow(jet[1].head<2>().norm(), 3.0) / std::abs(jet[1].x() * jet[2].y() - jet[1].y() * jet[2].x());
    EXPECT_NEAR(radius, 0.1, 0.001);
    const double step = 2e-4;
    const Vector2d a = (*cut)->at(nose_t - step).position_mm, b = (*cut)->at(nose_t).position_mm,
                   c = (*cut)->at(nose_t + step).position_mm;
    const double doubled = std::abs((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x());
    const double circle = (b - a).norm() * (c - b).norm() * (a - c).norm() / (2.0 * doubled);
    EXPECT_NEAR(circle, radius, 0.002);
}

TEST_F(SplineBody, TheSurfaceAloneIsOneFace) {
    StepOptions options;
    options.form = BodyForm::surface;
    ASSERT_TRUE(write_step(net_, options, file_));
    const auto shape = read_shape(file_);
    EXPECT_EQ(count_of(shape, TopAbs_SOLID), 0);
    EXPECT_EQ(count_of(shape, TopAbs_FACE), 1);
    EXPECT_TRUE(BRepCheck_Analyzer(shape).IsValid());
    EXPECT_TRUE(read_step(file_, "", 2).value()->cut(31.0));
}

double area_of(const TopoDS_Shape& shape) {
    GProp_GProps properties;
    BRepGProp::SurfaceProperties(shape, properties, 1e-6);
    return properties.Mass();
}

/// A hole on one side, one over the seam that meets it at a height, and a layer that is missing all round: what they
/// cover and what is left make the whole.
TEST_F(SplineBody, FacesStandAroundHoles) {
    const double round = net_.knots_u[net_.knots_u.size() - 4], high = net_.knots_v.back();
    StepOptions options;
    options.form = BodyForm::surface;
    const auto area_with = [&](const std::vector<NetHole>& holes, int faces) {
        net_.holes = holes;
        const auto written = write_step(net_, options, file_);
        EXPECT_TRUE(written) << written.error().text();
        const auto shape = read_shape(file_);
        EXPECT_TRUE(BRepCheck_Analyzer(shape).IsValid());
        EXPECT_EQ(count_of(shape, TopAbs_FACE), faces);
        EXPECT_EQ(count_of(shape, TopAbs_SOLID), 0);
        return area_of(shape);
    };
    const double whole = area_with({}, 1);
    const NetHole side{0.2 * round, 0.35 * round, 0.25 * high, 0.5 * high};
    const NetHole seam{0.9 * round, 0.1 * round, 0.5 * high, 0.75 * high};
    const NetHole layer{0.0, round, 0.75 * high, high};
    const NetHole but_side{side.u1, side.u0, side.v0, side.v1}, but_seam{seam.u1, seam.u0, seam.v0, seam.v1};
    const NetHole below{0.0, round, 0.0, 0.5 * high}, above{0.0, round, 0.5 * high, high};
    const NetHole under{0.0, round, 0.0, 0.25 * high}, over{0.0, round, 0.75 * high, high};
    const double of_side = area_with({but_side, under, above}, 1), of_seam = area_with({but_seam, below, over}, 2);
    const double of_layer = area_with({{0.0, round, 0.0, 0.75 * high}}, 1);
    const double left = area_with({side, seam, layer}, 4);
    EXPECT_NEAR(of_side + of_seam + of_layer + left, whole, 1e-4 * whole);
    EXPECT_GT(of_side, 0.02 * whole);
    // Holes that overlap are taken off once.
    EXPECT_NEAR(area_with({side, {0.3 * round, 0.35 * round, 0.25 * high, 0.5 * high}}, 4), whole - of_side,
                1e-4 * whole);
    // Below it sections can be cut as before.
    net_.holes = {side};
    ASSERT_TRUE(write_step(net_, options, file_));
    EXPECT_TRUE(read_step(file_, "", 2).value()->cut(0.1 * span_mm));

    net_.holes = {{0.0, round, 0.0, high}};
    const auto nothing = write_step(net_, options, file_);
    ASSERT_FALSE(nothing);
    EXPECT_NE(nothing.error().message.find("nothing of the surface"), std::string::npos) << nothing.error().text();
    net_.holes = {side};
    const auto solid = write_step(net_, {}, file_);
    ASSERT_FALSE(solid);
    EXPECT_NE(solid.error().message.find("holes"), std::string::npos) << solid.error().text();
}

TEST_F(SplineBody, TrianglesCloseAndHoldTheVolume) {
    const std::string file = folder_.path("blade.stl");
    const auto written = write_stl(net_, 0.02, file);
    ASSERT_TRUE(written) << written.error().text();
    const auto mesh = acquisition::read_mesh(file);
    ASSERT_TRUE(mesh) << mesh.error().text();
    double volume = 0.0;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& t : mesh->triangles) {
        volume += mesh->vertices[t[0]].dot(mesh->vertices[t[1]].cross(mesh->vertices[t[2]])) / 6.0;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto a = t[k], b = t[(k + 1) % 3];
            edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        }
    }
    EXPECT_TRUE(std::all_of(edges.begin(), edges.end(), [](const auto& edge) { return edge.second == 0; }));
    const double truth = volume_mm3(net_);
    std::printf("%zu triangles, volume %.4f mm3, truth %.4f mm3\n", mesh->triangles.size(), volume, truth);
    // Some 4800 mm2 of sides, each place within the deflection.
    EXPECT_NEAR(volume, truth, 4800.0 * 0.02);
}

TEST_F(SplineBody, WhatIsNoBodyIsNamed) {
    const auto refused = [&](const SplineNet& net, const std::string& said) {
        const auto written = write_step(net, {}, file_);
        ASSERT_FALSE(written);
        EXPECT_EQ(written.error().code, ErrorCode::fit_not_evaluable);
        EXPECT_NE(written.error().message.find(said), std::string::npos) << written.error().text();
    };
    auto bent = net_;
    bent.controls[3].z() -= 0.5;
    refused(bent, "is not plane");
    auto short_of_one = net_;
    short_of_one.controls.pop_back();
    refused(short_of_one, "no whole number of rows");
    auto knots = net_;
    knots.knots_v.pop_back();
    refused(knots, "");
    auto flat = net_;
    for (auto& p : flat.controls)
        p.y() = 0.0;
    refused(flat, "");
    const auto nowhere = write_step(net_, {}, folder_.path("absent/blade.step"));
    ASSERT_FALSE(nowhere);
    EXPECT_EQ(nowhere.error().code, ErrorCode::journal_io);
}

}  // namespace
}  // namespace cmm::cad
