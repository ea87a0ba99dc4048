// SPDX-License-Identifier: Apache-2.0
#include "sim/section_cut.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "core/text.hpp"
#include "sim/mesh.hpp"
#include "sim/mesh_file.hpp"
#include "sim/offset.hpp"
#include "tests/sim/test_blades.hpp"
#include "tests/sim/test_meshes.hpp"

namespace cmm::sim {
namespace {

double signed_area(const Contour& c) {
    double twice = 0.0;
    for (std::size_t i = 0; i < c.size(); ++i) {
        const auto &a = c[i], &b = c[(i + 1) % c.size()];
        twice += a.x() * b.y() - b.x() * a.y();
    }
    return 0.5 * twice;
}

TEST(SectionCut, MeshOfACone) {
    const MeshSurface cone(test::revolve({{10.0, 0.0}, {8.25, 7.0}, {5.0, 20.0}}, 100));
    for (const double z : {0.01, 7.0, 13.0, 19.99}) {  // 7: a plane through corners
        const auto cut = cut_section(cone, z);
        ASSERT_TRUE(cut) << cut.error().text();
        ASSERT_EQ(cut->size(), 1U);
        EXPECT_GE(cut->front().size(), 100U);
        const double outer = 10.0 - 0.25 * z;
        EXPECT_NEAR(signed_area(cut->front()), 50.0 * std::sin(2.0 * std::numbers::pi / 100.0) * outer * outer, 0.3);
        std::size_t warm = 0;
        for (const auto& p : cut->front())
            EXPECT_NEAR(cone.nearest({p.x(), p.y(), z}, warm).distance_mm, 0.0, 1e-12);
    }
    EXPECT_NE(cut_section(cone, 21.0).error().message.find("z = 21.000 mm: outside the part"), std::string::npos);
}

TEST(SectionCut, HolesRunClockwiseAndComeLast) {
    TriangleMesh pipe = test::revolve({{10.0, 0.0}, {10.0, 20.0}}, 60);
    TriangleMesh bore = test::revolve({{6.0, 1.0}, {6.0, 19.0}}, 60);
    const auto first = static_cast<std::uint32_t>(pipe.vertices.size());
    pipe.vertices.insert(pipe.vertices.end(), bore.vertices.begin(), bore.vertices.end());
    for (const auto& [a, b, c] : bore.triangles)
        pipe.triangles.push_back({first + a, first + c, first + b});
    const auto cut = cut_section(MeshSurface(pipe), 10.0);
    ASSERT_TRUE(cut);
    ASSERT_EQ(cut->size(), 2U);
    EXPECT_GT(signed_area((*cut)[0]), 300.0);
    EXPECT_LT(signed_area((*cut)[1]), -100.0);
}

TEST(SectionCut, OpenMeshIsAnError) {
    TriangleMesh mesh = test::revolve({{10.0, 0.0}, {10.0, 20.0}}, 20);
    mesh.triangles.erase(mesh.triangles.begin());
    EXPECT_NE(cut_section(MeshSurface(mesh), 10.0).error().message.find("hole"), std::string::npos);
}

TEST(SectionCut, BladeContourLiesOnTheBladeInThePlane) {
    const PatchSurface blade(BladePatch::make(test::twisted_blade(), 1.0).value());
    const auto cut = cut_section(blade, 33.3);
    ASSERT_TRUE(cut);
    const Contour& contour = cut->front();
    EXPECT_GT(signed_area(contour), 50.0);
    EXPECT_GE(contour.size(), 500U);
    std::size_t warm = 0;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const Eigen::Vector2d a = contour[i], m = 0.5 * (a + contour[(i + 1) % contour.size()]);
        EXPECT_NEAR(blade.nearest({a.x(), a.y(), 33.3}, warm).distance_mm, 0.0, 1e-9);
        EXPECT_NEAR(blade.nearest({m.x(), m.y(), 33.3}, warm).distance_mm, 0.0, 3e-4);
    }
    EXPECT_FALSE(cut_section(blade, 80.0));
}

TEST(SectionCut, GrownSurfacesAreCutAtTheirOwnDistance) {
    for (const double grow : {0.05, -0.05}) {
        const auto blade = std::make_shared<PatchSurface>(BladePatch::make(test::twisted_blade(), 1.0).value());
        const OffsetSurface grown(blade, grow);
        const auto cut = cut_section(grown, 20.0), base = cut_section(*blade, 20.0);
        ASSERT_TRUE(cut);
        std::size_t warm = 0;
        for (const auto& p : cut->front())
            EXPECT_NEAR(grown.nearest({p.x(), p.y(), 20.0}, warm).distance_mm, 0.0, 1e-7);
        EXPECT_GT((signed_area(cut->front()) - signed_area(base->front())) / grow, 70.0);  // about the perimeter
    }
}

/// The cuts that came with the mesh were made by another program.
TEST(SectionCut, EngineBladeAgreesWithTheCutsThatCameWithIt) {
    const std::string folder = "../shared/data/engine-blade/";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
    const MeshSurface mesh(read_mesh(folder + "engine-blade.ply").value());
    EXPECT_TRUE(mesh.defects().watertight());
    for (const char* z : {"300.0", "315.0", "330.0", "345.0", "360.0", "370.0"}) {
        std::istringstream file(core::read_file(folder + "section_z" + z + ".csv").value());
        Contour truth;
        for (std::string line; std::getline(file, line);) {
            if (line.starts_with('#')) continue;
            const auto fields = core::split(line, ',');
            truth.emplace_back(core::parse_number(fields[0]).value(), core::parse_number(fields[1]).value());
        }
        const auto cut = cut_section(mesh, core::parse_number(z).value());
        ASSERT_TRUE(cut) << cut.error().text();
        EXPECT_NEAR(signed_area(cut->front()), signed_area(truth), 0.01);
        double worst = 0.0;
        std::size_t warm = 0;
        for (const auto& p : truth) {
            const Eigen::Vector3d at(p.x(), p.y(), core::parse_number(z).value());
            worst = std::max(worst, std::abs(mesh.nearest(at, warm).distance_mm));
        }
        EXPECT_LT(worst, 2e-5);  // five decimals in the file
    }
}

}  // namespace
}  // namespace cmm::sim
