// SPDX-License-Identifier: Apache-2.0
#include "sim/mesh.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "core/rng.hpp"
#include "tests/sim/test_meshes.hpp"

namespace cmm::sim {
namespace {

Eigen::Vector3d random_point(core::Rng& rng, double half) {
    return {rng.uniform(-half, half), rng.uniform(-half, half), rng.uniform(-half, half)};
}

double brute_force(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
    double best = std::numeric_limits<double>::max();
    for (const auto& [a, b, c] : mesh.triangles) {
        const Eigen::Vector3d& corner = mesh.vertices[a];
        const auto foot = closest_on_triangle(p, {corner, mesh.vertices[b] - corner, mesh.vertices[c] - corner});
        best = std::min(best, (p - foot.point).norm());
    }
    return best;
}

TEST(MeshSurface, DistanceEqualsTheSmallestOverAllTriangles) {
    const TriangleMesh mesh = test::sphere(10.0, 40, 20);
    const MeshSurface surface(mesh);
    core::Rng rng(7);
    std::size_t warm = 0;
    for (int i = 0; i < 2000; ++i) {
        const Eigen::Vector3d p = random_point(rng, 15.0);
        const Contact contact = surface.nearest(p, warm);
        EXPECT_NEAR(std::abs(contact.distance_mm), brute_force(mesh, p), 1e-12);
        EXPECT_NEAR((contact.point + contact.distance_mm * contact.normal - p).norm(), 0.0, 1e-9);
    }
}

TEST(MeshSurface, SphereHasItsAnalyticDistanceWithinTheFacets) {
    const double radius = 10.0;
    const std::uint32_t around = 240, up = 120;
    const MeshSurface surface(test::sphere(radius, around, up));
    const double chord = radius * (1.0 - std::cos(std::numbers::pi / up)) * 2.0;
    core::Rng rng(3);
    std::size_t warm = 0;
    for (int i = 0; i < 2000; ++i) {
        const Eigen::Vector3d p = random_point(rng, 14.0);
        EXPECT_NEAR(surface.nearest(p, warm).distance_mm, p.norm() - radius, chord);
    }
    EXPECT_TRUE(surface.defects().watertight());
}

TEST(MeshSurface, CubeIsExactAtFacesEdgesAndCorners) {
    TriangleMesh cube;
    for (int i = 0; i < 8; ++i)
        cube.vertices.emplace_back(i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0);
    const std::array<std::array<std::uint32_t, 4>, 6> faces{
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& f : faces) {
        cube.triangles.push_back({f[0], f[1], f[2]});
        cube.triangles.push_back({f[0], f[2], f[3]});
    }
    const MeshSurface surface(cube);
    EXPECT_TRUE(surface.defects().watertight());
    core::Rng rng(5);
    std::size_t warm = 0;
    for (int i = 0; i < 5000; ++i) {
        const Eigen::Vector3d p = random_point(rng, 2.0);
        const Eigen::Vector3d q = p.cwiseAbs() - Eigen::Vector3d::Ones();
        const double truth = q.cwiseMax(0.0).norm() + std::min(0.0, q.maxCoeff());
        EXPECT_NEAR(surface.nearest(p, warm).distance_mm, truth, 1e-12);
    }
}

TEST(MeshSurface, SharpEdgesKeepTheirSign) {
    // A thin wedge: at its edge the two face normals disagree about most points; the pseudo normal decides.
    TriangleMesh wedge;
    wedge.vertices = {{0, 0, 0}, {10, 0.2, 0}, {10, -0.2, 0}, {0, 0, 5}, {10, 0.2, 5}, {10, -0.2, 5}};
    wedge.triangles = {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1}, {0, 2, 5}, {0, 5, 3}, {1, 4, 5}, {1, 5, 2}};
    const MeshSurface surface(wedge);
    std::size_t warm = 0;
    for (const double angle : {1.7, 2.2, 2.8, 3.14, 3.6, 4.2, 4.6}) {
        const Eigen::Vector3d p(std::cos(angle), std::sin(angle), 2.5);
        EXPECT_NEAR(surface.nearest(p, warm).distance_mm, 1.0, 1e-12) << angle;
    }
    EXPECT_LT(surface.nearest({5.0, 0.0, 2.5}, warm).distance_mm, 0.0);
}

TEST(MeshSurface, DistanceIsOneLipschitzAndTheWarmStartDoesNotMatter) {
    const MeshSurface surface(test::revolve({{3.0, 0.0}, {5.0, 10.0}, {4.0, 20.0}}, 31));
    core::Rng rng(11);
    std::size_t warm = 0;
    Eigen::Vector3d p = random_point(rng, 10.0);
    double before = surface.nearest(p, warm).distance_mm;
    for (int i = 0; i < 3000; ++i) {
        const Eigen::Vector3d step = random_point(rng, i % 2 ? 0.5 : 10.0);
        const Eigen::Vector3d next = (p + step).cwiseMax(-20.0).cwiseMin(20.0);
        const double now = surface.nearest(next, warm).distance_mm;
        std::size_t cold = 0;
        EXPECT_EQ(now, surface.nearest(next, cold).distance_mm);
        EXPECT_LE(std::abs(now - before), (next - p).norm() + 1e-12);
        before = now;
        p = next;
    }
}

TEST(MeshSurface, TurnsAMeshThatIsInsideOut) {
    TriangleMesh mesh = test::sphere(5.0, 20, 10);
    for (auto& t : mesh.triangles)
        std::swap(t[0], t[1]);
    const MeshSurface surface(mesh);
    std::size_t warm = 0;
    EXPECT_LT(surface.nearest(Eigen::Vector3d::Zero(), warm).distance_mm, 0.0);
    EXPECT_GT(surface.nearest({9.0, 0.0, 0.0}, warm).distance_mm, 0.0);
}

TEST(MeshSurface, CountsHolesAndContradictions) {
    TriangleMesh mesh = test::sphere(5.0, 20, 10);
    mesh.triangles.erase(mesh.triangles.begin() + 7);
    EXPECT_EQ(MeshSurface(mesh).defects().boundary_edges, 3U);
    std::swap(mesh.triangles[31][0], mesh.triangles[31][1]);
    EXPECT_EQ(MeshSurface(mesh).defects().twisted_edges, 3U);
    mesh.triangles.push_back(mesh.triangles[50]);
    EXPECT_EQ(MeshSurface(mesh).defects().crowded_edges, 3U);
    std::size_t warm = 0;
    EXPECT_NEAR(MeshSurface(mesh).nearest({0.0, 0.0, 9.0}, warm).distance_mm, 4.0, 1e-12);
}

TEST(MeshSurface, AnswersForTrianglesWithoutArea) {
    TriangleMesh mesh = test::sphere(5.0, 20, 10);
    const auto extra = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.emplace_back(7.0, 0.0, 0.0);
    mesh.vertices.emplace_back(8.0, 0.0, 0.0);
    mesh.vertices.emplace_back(9.0, 0.0, 0.0);
    mesh.triangles.push_back({extra, extra + 1, extra + 2});
    const MeshSurface surface(mesh);
    std::size_t warm = 0;
    EXPECT_NEAR(std::abs(surface.nearest({8.5, 0.3, 0.4}, warm).distance_mm), 0.5, 1e-12);
    EXPECT_NEAR(std::abs(surface.nearest({10.0, 0.0, 0.0}, warm).distance_mm), 1.0, 1e-12);
}

}  // namespace
}  // namespace cmm::sim
