// SPDX-License-Identifier: Apache-2.0
#include "sim/mesh_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "core/text.hpp"
#include "sim/mesh.hpp"

namespace cmm::sim {
namespace {

const std::string ascii_head =
    "ply\r\nformat ascii 1.0\r\ncomment a pyramid\r\nelement vertex 5\r\nproperty uchar red\r\nproperty double x\r\n"
    "property float y\r\nproperty double z\r\nproperty list uchar float extra\r\nelement edge 1\r\nproperty int a\r\n"
    "element face 5\r\nproperty list uchar int vertex_indices\r\nproperty uchar flag\r\nend_header\r\n";
const std::string ascii_body =
    "9 -1 -1 0 0\r\n9 1 -1 0 2 0.5 0.5\r\n9 1 1 0 0\r\n9 -1 1 0 0\r\n9 0 0 1.5 0\r\n77\r\n"
    "4 0 3 2 1 0\r\n3 0 1 4 0\r\n3 1 2 4 0\r\n3 2 3 4 0\r\n3 3 0 4 0\r\n";

template <class T>
void put(std::string& out, T value, bool big) {
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), &value, sizeof(T));
    if (big) std::reverse(bytes.begin(), bytes.end());  // the tests run on little-endian machines
    out.append(bytes.data(), bytes.size());
}

std::string binary_pyramid(bool big) {
    std::string ply =
        std::string("ply\nformat binary_") + (big ? "big" : "little") +
        "_endian 1.0\nelement vertex 5\nproperty double x\nproperty float y\nproperty float z\nproperty short w\n"
        "element face 5\nproperty uchar flag\nproperty list ushort uint vertex_index\nend_header\n";
    const double points[5][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1.5}};
    for (const auto& p : points) {
        put(ply, p[0], big);
        put(ply, static_cast<float>(p[1]), big);
        put(ply, static_cast<float>(p[2]), big);
        put(ply, std::int16_t{-7}, big);
    }
    const std::vector<std::vector<std::uint32_t>> faces{{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
    for (const auto& face : faces) {
        put(ply, std::uint8_t{1}, big);
        put(ply, static_cast<std::uint16_t>(face.size()), big);
        for (const auto corner : face)
            put(ply, corner, big);
    }
    return ply;
}

void expect_pyramid(const core::Result<TriangleMesh>& mesh) {
    ASSERT_TRUE(mesh) << mesh.error().text();
    EXPECT_EQ(mesh->vertices.size(), 5U);
    EXPECT_EQ(mesh->triangles.size(), 6U);
    const MeshSurface surface(*mesh);
    EXPECT_TRUE(surface.defects().watertight());
    EXPECT_EQ(surface.box().high, Eigen::Vector3d(1.0, 1.0, 1.5));
    std::size_t warm = 0;
    EXPECT_NEAR(surface.nearest({0.0, 0.0, -0.25}, warm).distance_mm, 0.25, 1e-12);
    EXPECT_NEAR(surface.nearest({0.0, 0.0, 0.1}, warm).distance_mm, -0.1, 1e-12);
}

std::string message(const core::Result<TriangleMesh>& mesh) {
    return mesh ? "read" : mesh.error().message;
}

TEST(MeshFile, PlyAsciiWithExtraPropertiesPolygonsAndCrlf) {
    expect_pyramid(parse_ply(ascii_head + ascii_body, "p.ply"));
}

TEST(MeshFile, PlyBinaryOfBothByteOrders) {
    expect_pyramid(parse_ply(binary_pyramid(false), "p.ply"));
    expect_pyramid(parse_ply(binary_pyramid(true), "p.ply"));
}

TEST(MeshFile, PlyErrorsSayWhere) {
    std::string body = ascii_body;
    body.replace(body.find("9 1 1 0"), 7, "9 1 q 0");
    EXPECT_EQ(message(parse_ply(ascii_head + body, "p.ply")), "p.ply:18: not a number: 'q' (element vertex)");
    body = ascii_body;
    body.replace(body.find("3 1 2 4"), 7, "3 1 2 5");
    EXPECT_EQ(message(parse_ply(ascii_head + body, "p.ply")), "p.ply:24: a face uses vertex 5 of 5 (element face)");
    EXPECT_NE(message(parse_ply(ascii_head + "9 1 1", "p.ply")).find("p.ply:16: the file ends before"),
              std::string::npos);
    EXPECT_NE(
        message(parse_ply("ply\nformat ascii 2\nbanana 3\n", "p.ply")).find("p.ply:3: unknown header line: 'banana 3'"),
        std::string::npos);
    EXPECT_NE(message(parse_ply("ply\nformat ascii 1.0\n", "p.ply")).find("without end_header"), std::string::npos);
    std::string cut = binary_pyramid(false);
    cut.resize(cut.size() - 3);
    EXPECT_EQ(message(parse_ply(cut, "p.ply")).substr(0, 12), "p.ply: byte ");
    EXPECT_NE(message(parse_ply("ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n", "p.ply"))
                  .find("no triangles"),
              std::string::npos);
}

const float tetrahedron[4][3][3] = {{{0, 0, 0}, {0, 2, 0}, {2, 0, 0}},
                                    {{0, 0, 0}, {2, 0, 0}, {0, 0, 2}},
                                    {{-0.0F, 0, 0}, {0, 0, 2}, {0, 2, 0}},
                                    {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}};

TEST(MeshFile, StlAsciiAndBinaryAreWelded) {
    std::string text = "solid tetra hedron\n", binary(80, ' ');
    binary.replace(0, 5, "solid");  // as some programs do
    put(binary, std::uint32_t{4}, false);
    for (const auto& facet : tetrahedron) {
        text += " facet normal 0 0 0\n  outer loop\n";
        for (int k = 0; k < 3; ++k)
            put(binary, 0.0F, false);
        for (const auto& corner : facet) {
            text += "   vertex";
            for (const float v : corner) {
                text += " " + core::fixed(static_cast<double>(v), 3);
                put(binary, v, false);
            }
            text += "\n";
        }
        text += "  endloop\n endfacet\n";
        put(binary, std::uint16_t{0}, false);
    }
    text += "endsolid\n";
    for (const auto& content : {text, binary}) {
        const auto mesh = parse_stl(content, "t.stl");
        ASSERT_TRUE(mesh) << mesh.error().text();
        EXPECT_EQ(mesh->vertices.size(), 4U);
        EXPECT_EQ(mesh->triangles.size(), 4U);
        EXPECT_TRUE(MeshSurface(*mesh).defects().watertight());
    }
    binary.resize(binary.size() - 10);
    EXPECT_NE(message(parse_stl("Solid" + binary.substr(5), "t.stl")).find("ends before its 4 facets"),
              std::string::npos);
}

TEST(MeshFile, StlErrorsSayWhere) {
    EXPECT_EQ(message(parse_stl("solid\nfacet normal 0 0 1\nouter loop\nvertex 1 2 x\n", "t.stl")),
              "t.stl:4: not a number: 'x'");
    EXPECT_EQ(message(parse_stl("solid\nfacet\nouter loop\nvertex 1 2 3\nendloop\n", "t.stl")),
              "t.stl:5: a facet with 1 corners");
    EXPECT_EQ(message(parse_stl("nonsense\n", "t.stl")),
              "t.stl:1: neither STL text nor a binary STL of the right length: 'nonsense'");
    EXPECT_EQ(message(parse_stl("solid\nendsolid\n", "t.stl")), "t.stl: no triangles in it");
    EXPECT_EQ(read_mesh("no/such.ply").error().code, core::ErrorCode::input_missing);
}

}  // namespace
}  // namespace cmm::sim
