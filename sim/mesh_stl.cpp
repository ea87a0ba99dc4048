// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>

#include "core/text.hpp"
#include "sim/mesh_file.hpp"

namespace cmm::sim {

using core::ErrorCode;
using core::fail;
using core::Result;

namespace {

constexpr std::size_t binary_head = 84, binary_facet = 50;

/// Collects triangles and gives equal corners one index.
class Welder {
  public:
    void add(const std::array<Eigen::Vector3d, 3>& corners) {
        std::array<std::uint32_t, 3> triangle{};
        for (std::size_t k = 0; k < 3; ++k) {
            // + 0.0 makes -0.0 equal 0.0
            const std::array<double, 3> key{corners[k].x() + 0.0, corners[k].y() + 0.0, corners[k].z() + 0.0};
            const auto [place, added] = index_.try_emplace(key, static_cast<std::uint32_t>(mesh_.vertices.size()));
            if (added) mesh_.vertices.emplace_back(key[0], key[1], key[2]);
            triangle[k] = place->second;
        }
        if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]) {
            mesh_.triangles.push_back(triangle);
        }
    }
    Result<TriangleMesh> finish(const std::string& name) && {
        if (mesh_.triangles.empty()) return fail(ErrorCode::input_invalid, name + ": no triangles in it");
        return std::move(mesh_);
    }

  private:
    TriangleMesh mesh_;
    std::map<std::array<double, 3>, std::uint32_t> index_;
};

std::uint32_t little_u32(const char* bytes) {
    const auto byte = [&](int k) {
        return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[k])) << (8 * k);
    };
    return byte(0) | byte(1) | byte(2) | byte(3);
}

Result<TriangleMesh> parse_binary(std::string_view content, const std::string& name) {
    const std::size_t count = little_u32(content.data() + 80);
    const std::size_t needed = binary_head + count * binary_facet;
    if (content.size() < needed) {
        return fail(ErrorCode::input_invalid, name + ": byte " + std::to_string(content.size()) +
                                                  ": the file ends before its " + std::to_string(count) +
                                                  " facets are there");
    }
    Welder welder;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t first = binary_head + i * binary_facet + 12;  // after the facet's normal
        std::array<Eigen::Vector3d, 3> corners;
        for (std::size_t k = 0; k < 9; ++k) {
            const std::size_t at = first + 4 * k;
            const auto value = static_cast<double>(std::bit_cast<float>(little_u32(content.data() + at)));
            if (!std::isfinite(value)) {
                return fail(ErrorCode::input_invalid,
                            name + ": byte " + std::to_string(at) + ": a coordinate is not finite");
            }
            corners[k / 3][static_cast<Eigen::Index>(k % 3)] = value;
        }
        welder.add(corners);
    }
    return std::move(welder).finish(name);
}

Result<TriangleMesh> parse_text(std::string_view content, const std::string& name) {
    Welder welder;
    std::array<Eigen::Vector3d, 3> corners;
    std::size_t number = 0, line_number = 0;
    const auto bad = [&](const std::string& what) {
        return fail(ErrorCode::input_invalid, name + ":" + std::to_string(line_number) + ": " + what);
    };
    while (!content.empty()) {
        const std::size_t end = std::min(content.find('\n'), content.size());
        const auto words = core::split(core::trim(content.substr(0, end)), ' ');
        content.remove_prefix(std::min(end + 1, content.size()));
        ++line_number;
        if (words.empty()) continue;
        if (words[0] == "endloop") {
            if (number != 3) return bad("a facet with " + std::to_string(number) + " corners");
            welder.add(corners);
            number = 0;
        } else if (words[0] == "vertex") {
            if (words.size() != 4) return bad("vertex needs three numbers");
            if (number >= 3) return bad("a facet with more than 3 corners");
            for (std::size_t k = 0; k < 3; ++k) {
                const auto value = core::parse_number(words[k + 1]);
                if (!value) return bad("not a number: '" + std::string(words[k + 1].substr(0, 40)) + "'");
                corners[number][static_cast<Eigen::Index>(k)] = *value;
            }
            ++number;
        } else if (words[0] != "solid" && words[0] != "facet" && words[0] != "outer" && words[0] != "endfacet" &&
                   words[0] != "endsolid") {
            return bad("neither STL text nor a binary STL of the right length: '" +
                       std::string(words[0].substr(0, 40)) + "'");
        }
    }
    if (number != 0) return bad("the file ends within a facet");
    return std::move(welder).finish(name);
}

}  // namespace

Result<TriangleMesh> parse_stl(std::string_view content, const std::string& name) {
    // Some programs start binary files with "solid" too; the length tells.
    const bool exact_length =
        content.size() >= binary_head &&
        content.size() == binary_head + std::size_t{little_u32(content.data() + 80)} * binary_facet;
    const bool text = core::trim(content).starts_with("solid");
    if (exact_length || (!text && content.size() >= binary_head)) return parse_binary(content, name);
    return parse_text(content, name);
}

}  // namespace cmm::sim
