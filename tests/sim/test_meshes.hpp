// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "sim/bvh.hpp"

/// Meshes of bodies whose distance is known, for tests.
namespace cmm::sim::test {

/// A closed surface of revolution about z from a profile (radius, z) that rises in z; counter-clockwise outside. Ends
/// with a radius above 0 are closed by a fan.
inline TriangleMesh revolve(const std::vector<Eigen::Vector2d>& profile, std::uint32_t around) {
    TriangleMesh mesh;
    const auto rings = static_cast<std::uint32_t>(profile.size());
    for (const auto& p : profile) {
        for (std::uint32_t i = 0; i < around; ++i) {
            const double a = 2.0 * std::numbers::pi * i / around;
            mesh.vertices.emplace_back(p.x() * std::cos(a), p.x() * std::sin(a), p.y());
        }
    }
    const auto bottom = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.emplace_back(0.0, 0.0, profile.front().y());
    mesh.vertices.emplace_back(0.0, 0.0, profile.back().y());
    for (std::uint32_t i = 0; i < around; ++i) {
        const std::uint32_t next = (i + 1) % around, top = (rings - 1) * around;
        for (std::uint32_t k = 0; k + 1 < rings; ++k) {
            const std::uint32_t low = k * around, high = low + around;
            mesh.triangles.push_back({low + i, low + next, high + next});
            mesh.triangles.push_back({low + i, high + next, high + i});
        }
        mesh.triangles.push_back({bottom, next, i});
        mesh.triangles.push_back({bottom + 1, top + i, top + next});
    }
    return mesh;
}

/// A sphere about the origin whose corners lie on it.
inline TriangleMesh sphere(double radius, std::uint32_t around, std::uint32_t up) {
    std::vector<Eigen::Vector2d> profile;
    for (std::uint32_t k = 1; k < up; ++k) {
        const double a = std::numbers::pi * k / up;
        profile.emplace_back(radius * std::sin(a), -radius * std::cos(a));
    }
    TriangleMesh mesh = revolve(profile, around);
    mesh.vertices[mesh.vertices.size() - 2].z() = -radius;
    mesh.vertices.back().z() = radius;
    return mesh;
}

}  // namespace cmm::sim::test
