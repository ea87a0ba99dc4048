// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cstring>
#include <map>

#include "acquisition/delimited_file.hpp"
#include "acquisition/triangle_mesh.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;
using core::fail;

constexpr std::size_t binary_header = 84, binary_facet = 50;

/// Joins equal corners: STL repeats them in every facet.
class Welder {
  public:
    std::uint32_t vertex(const Eigen::Vector3d& p) {
        // Adding zero turns -0.0 into 0.0.
        const std::array<double, 3> key{p.x() + 0.0, p.y() + 0.0, p.z() + 0.0};
        const auto [at, is_new] = index_.emplace(key, static_cast<std::uint32_t>(mesh.vertices.size()));
        if (is_new) mesh.vertices.push_back(p);
        return at->second;
    }
    void facet(const std::array<Eigen::Vector3d, 3>& corners) {
        const std::array<std::uint32_t, 3> t{vertex(corners[0]), vertex(corners[1]), vertex(corners[2])};
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles.push_back(t);
    }
    TriangleMesh mesh;

  private:
    std::map<std::array<double, 3>, std::uint32_t> index_;
};

std::uint32_t little_u32(std::string_view bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;)
        value = (value << 8U) | static_cast<unsigned char>(bytes[i]);
    return value;
}

core::Result<TriangleMesh> read_binary(std::string_view content, const std::string& name) {
    Welder welder;
    for (std::size_t at = binary_header; at + binary_facet <= content.size(); at += binary_facet) {
        std::array<Eigen::Vector3d, 3> corners;
        for (std::size_t k = 0; k < 9; ++k) {
            const auto bits = little_u32(content.substr(at + 12 + 4 * k, 4));
            corners[k / 3][static_cast<Eigen::Index>(k % 3)] = static_cast<double>(std::bit_cast<float>(bits));
            if ((bits & 0x7F800000U) == 0x7F800000U) {  // an exponent of ones: infinite, or not a number
                return fail(ErrorCode::input_invalid,
                            name + ": byte " + std::to_string(at + 12 + 4 * k) + ": a corner of facet " +
                                std::to_string((at - binary_header) / binary_facet + 1) + " is not a finite number");
            }
        }
        welder.facet(corners);
    }
    return std::move(welder.mesh);
}

core::Result<TriangleMesh> read_ascii(std::string_view content, const std::string& name) {
    Welder welder;
    std::array<Eigen::Vector3d, 3> corners;
    std::size_t corner = 0;
    const auto lines = text_lines(content);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const auto words = core::split(lines[i], ' ');
        if (words.empty() || words[0] != "vertex") continue;
        Eigen::Vector3d point;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto value = words.size() == 4 ? core::parse_number(words[axis + 1]) : std::nullopt;
            if (!value)
                return fail(ErrorCode::input_invalid, place(name, i + 1, 1) + "a vertex needs three finite numbers");
            point[static_cast<Eigen::Index>(axis)] = *value;
        }
        corners.at(corner++) = point;
        if (corner < 3) continue;
        welder.facet(corners);
        corner = 0;
    }
    if (corner != 0) return fail(ErrorCode::input_invalid, name + ": the last facet is not complete");
    return std::move(welder.mesh);
}

}  // namespace

core::Result<TriangleMesh> read_stl(std::string_view content, const std::string& name) {
    // Some writers start binary files with "solid": the size tells.
    if (content.size() >= binary_header) {
        const std::size_t facets = little_u32(content.substr(80, 4));
        if (content.size() == binary_header + facets * binary_facet) return read_binary(content, name);
    }
    if (core::trim(content.substr(0, 80)).starts_with("solid")) return read_ascii(content, name);
    return fail(ErrorCode::input_invalid, name + ": neither PLY nor STL (or a truncated binary STL)");
}

}  // namespace cmm::acquisition
