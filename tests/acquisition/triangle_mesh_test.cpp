// SPDX-License-Identifier: Apache-2.0
#include "acquisition/triangle_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tests/acquisition/temp_folder.hpp"

namespace cmm::acquisition {
namespace {

const std::vector<std::array<float, 3>> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::vector<std::array<std::uint32_t, 3>> faces{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

template <class T>
void put(std::string& out, T value, bool big) {
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), &value, sizeof(T));
    if (big) std::reverse(bytes.begin(), bytes.end());
    out.append(bytes.data(), sizeof(T));
}

std::string binary_ply(bool big) {
    std::string out = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                      "_endian 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
                      "z\nproperty uchar red\n"
                      "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
    for (const auto& c : corners) {
        for (const float v : c)
            put(out, v, big);
        put(out, std::uint8_t{7}, big);
    }
    for (const auto& f : faces) {
        put(out, std::uint8_t{3}, big);
        for (const auto v : f)
            put(out, static_cast<std::int32_t>(v), big);
    }
    return out;
}

std::string binary_stl() {
    std::string out = "solid but binary";
    out.resize(80, ' ');
    put(out, std::uint32_t{4}, false);
    for (const auto& f : faces) {
        for (int i = 0; i < 3; ++i)
            put(out, 0.0F, false);
        for (const auto v : f) {
            for (const float x : corners[v])
                put(out, x, false);
        }
        put(out, std::uint16_t{0}, false);
    }
    return out;
}

std::string ascii_stl() {
    std::string out = "solid t\n";
    for (const auto& f : faces) {
        out += " facet normal 0 0 0\n  outer loop\n";
        for (const auto v : f)
            out += "   vertex " + std::to_string(corners[v][0]) + " " + std::to_string(corners[v][1]) + " " +
                   std::to_string(corners[v][2]) + "\n";
        out += "  endloop\n endfacet\n";
    }
    return out + "endsolid t\n";
}

const std::string ascii_ply =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\nelement face 4\n"
    "property list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 "
    "3\n";

double volume(const TriangleMesh& mesh) {
    double six = 0.0;
    for (const auto& t : mesh.triangles) {
        const auto &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        six += a.x() * (b.y() * c.z() - b.z() * c.y()) - a.y() * (b.x() * c.z() - b.z() * c.x()) +
               a.z() * (b.x() * c.y() - b.y() * c.x());
    }
    return six / 6.0;
}

TEST(TriangleMesh, ReadsEveryFormatToTheSameMesh) {
    const TempFolder folder;
    for (const auto& text : {ascii_ply, binary_ply(false), binary_ply(true), ascii_stl(), binary_stl()}) {
        const auto mesh = read_mesh(folder.write("m.mesh", text));
        ASSERT_TRUE(mesh) << mesh.error().text();
        EXPECT_EQ(mesh->vertices.size(), 4U);
        EXPECT_EQ(mesh->triangles.size(), 4U);
        EXPECT_NEAR(volume(*mesh), 1.0 / 6.0, 1e-12);
    }
}

TEST(TriangleMesh, SaysWhatIsWrong) {
    const TempFolder folder;
    const auto error = [&](const std::string& text) {
        const auto mesh = read_mesh(folder.write("m.ply", text));
        return mesh ? std::string() : mesh.error().message;
    };
    EXPECT_NE(error(binary_ply(false).substr(0, 240)).find("cannot be read (truncated"), std::string::npos);
    EXPECT_NE(error(binary_stl().substr(0, 200)).size(), 0U);
    std::string not_finite = binary_stl();
    not_finite.replace(84 + 50 + 12, 4, "\xFF\xFF\xFF\xFF");
    EXPECT_NE(error(not_finite).find("byte 146: a corner of facet 2 is not a finite number"), std::string::npos);
    EXPECT_NE(error(std::string("\x01\x02", 2)).find("neither PLY nor STL"), std::string::npos);
    EXPECT_NE(error(ascii_ply.substr(0, ascii_ply.size() - 8) + "3 2 0 9\n").find("names vertex 9 of 4"),
              std::string::npos);
    EXPECT_NE(error("ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n")
                  .find("m.ply:4:1: unknown property type"),
              std::string::npos);
    EXPECT_NE(error("ply\nformat ascii 1.0\nelement vertex 4\n").find("no end_header"), std::string::npos);
    EXPECT_EQ(read_mesh(folder.path("absent.ply")).error().code, core::ErrorCode::input_missing);
}

}  // namespace
}  // namespace cmm::acquisition
