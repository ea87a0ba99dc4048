// SPDX-License-Identifier: Apache-2.0
#include "acquisition/crv_file.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "acquisition/delimited_file.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

bool names_a_profile(std::string_view comment) {
    constexpr std::string_view word = "profile";
    const auto same = [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; };
    return std::search(comment.begin(), comment.end(), word.begin(), word.end(), same) != comment.end();
}

core::Result<Eigen::Vector3d> read_point(std::string_view line, const std::string& name, std::size_t number) {
    const auto fields = core::split(line, ' ');
    if (fields.size() != 3) {
        return core::fail(core::ErrorCode::input_invalid, place(name, number, 1) +
                                                              "a point needs three numbers x y z, found " +
                                                              std::to_string(fields.size()) + " fields");
    }
    Eigen::Vector3d point;
    for (int axis = 0; axis < 3; ++axis) {
        const auto field = fields[static_cast<std::size_t>(axis)];
        const DelimitedCell cell{field, static_cast<std::size_t>(field.data() - line.data()) + 1};
        const auto value = cell_number(cell, std::string(1, "xyz"[axis]), name, number);
        if (!value) return tl::unexpected(value.error());
        point[axis] = *value;
    }
    return point;
}

}  // namespace

core::Result<std::vector<PointSection>> read_crv(std::string_view content, const std::string& name) {
    if (auto status = require_text(content, name); !status) return tl::unexpected(status.error());
    std::vector<PointSection> profiles;
    const auto lines = text_lines(content);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        std::string_view comment;
        const auto line = without_comment(lines[i], comment);
        if (names_a_profile(comment)) profiles.push_back({std::string(comment), {}, {}, {}});
        if (line.empty()) continue;
        const auto point = read_point(line, name, i + 1);
        if (!point) return tl::unexpected(point.error());
        if (profiles.empty()) profiles.push_back({std::filesystem::path(name).stem().string(), {}, {}, {}});
        profiles.back().points_mm.push_back(*point);
    }
    return profiles;
}

}  // namespace cmm::acquisition
