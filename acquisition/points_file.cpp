// SPDX-License-Identifier: Apache-2.0
#include "acquisition/points_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "acquisition/crv_file.hpp"
#include "acquisition/delimited_file.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;
using core::fail;
using Sections = std::vector<PointSection>;

constexpr double z_step_mm = 0.020;  // a larger step in z begins another section
constexpr std::size_t fewest_points = 3;

std::string stem(const std::string& path) {
    return std::filesystem::path(path).stem().string();
}

std::string extension(const std::string& path) {
    return core::in_small_letters(std::filesystem::path(path).extension().string());
}

/// The number that starts `text`, as in "300.0 of engine-blade.ply".
std::optional<double> leading_number(std::string_view text) {
    text = core::trim(text);
    std::size_t end = text.find_first_not_of("+-0123456789.eE");
    end = std::min(end, text.size());
    for (; end > 0; --end) {
        if (const auto value = core::parse_number(text.substr(0, end))) return value;
    }
    return std::nullopt;
}

bool is_word_character(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0;
}

/// "z=12.5", "z_mm = 12.5", "Z= -3" anywhere in a comment.
std::optional<double> height_in_comment(std::string_view text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        if ((text[i] != 'z' && text[i] != 'Z') || (i > 0 && is_word_character(text[i - 1]))) continue;
        auto rest = text.substr(i + 1);
        if (rest.starts_with("_mm")) rest.remove_prefix(3);
        rest = core::trim(rest);
        if (!rest.starts_with('=')) continue;
        if (const auto z = leading_number(rest.substr(1))) return z;
    }
    return std::nullopt;
}

/// The height of a two-column file: a comment "z=12.5", or a file name with "_z12.5" or "z=12.5".
std::optional<double> stated_height(const DelimitedTable& table, const std::string& path) {
    for (const auto comment : table.comments) {
        if (const auto z = height_in_comment(comment)) return z;
    }
    const std::string name = stem(path);
    if (const auto z = height_in_comment(name)) return z;
    for (auto at = name.find("_z"); at != std::string::npos; at = name.find("_z", at + 1)) {
        if (const auto z = leading_number(std::string_view(name).substr(at + 2))) return z;
    }
    return std::nullopt;
}

/// Where the wanted fields are in a row.
struct Columns {
    std::array<std::optional<std::size_t>, 3> axis;
    std::optional<std::size_t> section, flag, sequence, pass;
};

std::optional<std::size_t> find_column(const DelimitedTable& table, std::initializer_list<std::string_view> names) {
    for (const auto name : names) {
        const auto at = std::find(table.header.begin(), table.header.end(), name);
        if (at != table.header.end()) return static_cast<std::size_t>(at - table.header.begin());
    }
    return std::nullopt;
}

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const auto& word : words)
        text += (text.empty() ? "" : ", ") + word;
    return text;
}

core::Result<Columns> columns_of(const DelimitedTable& table, const std::string& path) {
    Columns columns;
    if (table.header.empty()) {
        const std::size_t width = table.rows.front().cells.size();
        if (width < 2)
            return fail(ErrorCode::input_invalid, place(path, table.rows.front().line, 1) + "only one column");
        for (std::size_t i = 0; i < std::min<std::size_t>(width, 3); ++i)
            columns.axis[i] = i;
        // Scanner exports append normals or colours: more than five columns hold no section.
        if (width == 4 || width == 5) columns.section = 3;
        if (width == 5) columns.flag = 4;
        return columns;
    }
    columns.axis = {find_column(table, {"x", "x_mm"}), find_column(table, {"y", "y_mm"}),
                    find_column(table, {"z", "z_mm"})};
    columns.section = find_column(table, {"section", "section_name", "section_index"});
    columns.flag = find_column(table, {"flag", "flags"});
    columns.sequence = find_column(table, {"seq"});
    columns.pass = find_column(table, {"pass"});
    for (std::size_t i = 0; i < 2; ++i) {
        if (columns.axis[i]) continue;
        const std::string letter(1, "xyz"[i]);
        return fail(ErrorCode::input_invalid, path + ": no column " + letter + " (or " + letter +
                                                  "_mm); the columns are: " + joined(table.header));
    }
    return columns;
}

/// A row as a point of one section.
struct ReadPoint {
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
    std::string_view section;
    std::uint16_t flag = 0;
    std::optional<std::uint64_t> sequence;
    std::uint8_t pass = 0;
};

/// A whole number from 0 to `most` in a cell.
core::Result<double> whole_number(const DelimitedCell& cell, const std::string& what, double most,
                                  const std::string& path, std::size_t line) {
    const auto value = cell_number(cell, what, path, line);
    if (!value) return value;
    if (*value >= 0.0 && *value <= most && *value == std::floor(*value)) return value;
    return fail(ErrorCode::input_invalid, place(path, line, cell.column) + what + " must be a whole number from 0 to " +
                                              core::fixed(most, 0) + ", not '" + std::string(cell.text) + "'");
}

core::Result<ReadPoint> read_row(const DelimitedRow& row, const Columns& columns, double stated_z,
                                 const std::string& path) {
    ReadPoint point;
    point.position_mm.z() = stated_z;
    for (std::size_t i = 0; i < 3; ++i) {
        if (!columns.axis[i]) continue;
        const auto value = cell_number(row.cells[*columns.axis[i]], std::string(1, "xyz"[i]), path, row.line);
        if (!value) return tl::unexpected(value.error());
        point.position_mm[static_cast<Eigen::Index>(i)] = *value;
    }
    if (columns.section) {
        const auto& cell = row.cells[*columns.section];
        if (cell.text.empty())
            return fail(ErrorCode::input_invalid, place(path, row.line, cell.column) + "section is empty");
        point.section = cell.text;
    }
    if (columns.flag && !row.cells[*columns.flag].text.empty()) {
        const auto value = whole_number(row.cells[*columns.flag], "flag", 65535.0, path, row.line);
        if (!value) return tl::unexpected(value.error());
        point.flag = static_cast<std::uint16_t>(*value);
    }
    if (columns.sequence) {
        const auto value = whole_number(row.cells[*columns.sequence], "seq", 9e15, path, row.line);
        if (!value) return tl::unexpected(value.error());
        point.sequence = static_cast<std::uint64_t>(*value);
    }
    if (columns.pass && !row.cells[*columns.pass].text.empty()) {
        const auto value = whole_number(row.cells[*columns.pass], "pass", 255.0, path, row.line);
        if (!value) return tl::unexpected(value.error());
        point.pass = static_cast<std::uint8_t>(*value);
    }
    return point;
}

void append(PointSection& section, const ReadPoint& point) {
    section.points_mm.push_back(point.position_mm);
    section.flags.push_back(point.flag);
    section.passes.push_back(point.pass);
    if (point.sequence) section.sequences.push_back(*point.sequence);
}

Sections by_column(const std::vector<ReadPoint>& points) {
    Sections sections;
    std::map<std::string_view, std::size_t> index;
    for (const auto& point : points) {
        const auto [at, is_new] = index.emplace(point.section, sections.size());
        if (is_new) sections.push_back({std::string(point.section), {}, {}, {}});
        append(sections[at->second], point);
    }
    return sections;
}

/// Runs of constant z; runs at the same height are one section. A curve whose z changes from point to point (a section
/// on a stream surface) has no such runs and stays whole.
/// Height of each point as its neighbours have it (median of 7): a bad point on a leaning wall is off in z as well, and
/// neither it nor a run of three may begin a section. A step stays where it is.
std::vector<double> heights_of(const std::vector<ReadPoint>& points) {
    constexpr std::size_t half = 3;
    std::vector<double> heights;
    heights.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::size_t low = i - std::min(i, half);
        const std::size_t high = std::min(points.size(), i + half + 1);
        std::vector<double> near;
        for (std::size_t k = low; k < high; ++k)
            near.push_back(points[k].position_mm.z());
        const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
        std::nth_element(near.begin(), middle, near.end());
        heights.push_back(*middle);
    }
    return heights;
}

Sections by_height(const std::vector<ReadPoint>& points, const std::string& path) {
    const auto heights = heights_of(points);
    std::vector<std::size_t> starts{0};
    for (std::size_t i = 1; i < points.size(); ++i) {
        if (std::abs(heights[i] - heights[starts.back()]) > z_step_mm) starts.push_back(i);
    }
    Sections sections;
    const bool has_runs = starts.size() * 4 <= points.size();
    if (!has_runs) starts.resize(1);
    starts.push_back(points.size());
    for (std::size_t run = 0; run + 1 < starts.size(); ++run) {
        const double z = heights[starts[run]];
        auto same = std::find_if(sections.begin(), sections.end(), [&](const PointSection& section) {
            return std::abs(section.z_mm() - z) <= z_step_mm;
        });
        if (same == sections.end()) same = sections.insert(sections.end(), {core::fixed(z, 3), {}, {}, {}});
        for (std::size_t i = starts[run]; i < starts[run + 1]; ++i)
            append(*same, points[i]);
    }
    if (sections.size() == 1) sections.front().name = stem(path);
    return sections;
}

core::Result<Sections> read_table(std::string_view content, const std::string& path) {
    const auto table = read_delimited(content, path);
    if (!table) return tl::unexpected(table.error());
    if (table->rows.empty()) return fail(ErrorCode::input_invalid, path + ": no points after the header");
    const auto columns = columns_of(*table, path);
    if (!columns) return tl::unexpected(columns.error());
    const auto z = columns->axis[2] ? std::optional<double>(0.0) : stated_height(*table, path);
    if (!z) {
        return fail(
            ErrorCode::input_invalid,
            path + ": no column z (or z_mm), and neither a comment 'z=<number>' nor '_z<number>' in the file name");
    }
    std::vector<ReadPoint> points;
    points.reserve(table->rows.size());
    for (const auto& row : table->rows) {
        const auto point = read_row(row, *columns, *z, path);
        if (!point) return tl::unexpected(point.error());
        points.push_back(*point);
    }
    return columns->section ? by_column(points) : by_height(points, path);
}

bool looks_like_crv(std::string_view content) {
    for (const auto line : text_lines(content.substr(0, 4096))) {
        std::string_view comment;
        const bool has_data = !without_comment(line, comment).empty();
        if (comment.find("Profile ") != std::string_view::npos) return true;
        if (has_data) return false;
    }
    return false;
}

core::Status require_points(const Sections& sections, const std::string& path) {
    if (sections.empty()) return fail(ErrorCode::input_invalid, path + ": no points");
    for (const auto& section : sections) {
        if (section.points_mm.size() >= fewest_points) continue;
        return fail(ErrorCode::input_invalid, path + ": section '" + section.name + "' has " +
                                                  std::to_string(section.points_mm.size()) +
                                                  " points; a section needs at least 3");
    }
    return {};
}

}  // namespace

double PointSection::z_mm() const {
    double sum = 0.0;
    for (const auto& point : points_mm)
        sum += point.z();
    return points_mm.empty() ? 0.0 : sum / static_cast<double>(points_mm.size());
}

core::Result<std::vector<PointSection>> read_points(const std::string& path) {
    const auto content = core::read_file(path);
    if (!content) return tl::unexpected(content.error());
    const std::string kind = extension(path);
    const bool crv = kind == ".crv" || kind == ".curve" || (kind != ".csv" && looks_like_crv(*content));
    auto sections = crv ? read_crv(*content, path) : read_table(*content, path);
    if (!sections) return sections;
    if (auto status = require_points(*sections, path); !status) return tl::unexpected(status.error());
    for (auto& section : *sections) {
        const bool plain =
            std::all_of(section.flags.begin(), section.flags.end(), [](std::uint16_t f) { return f == 0; });
        if (plain) section.flags.clear();
        const bool one_lap =
            std::all_of(section.passes.begin(), section.passes.end(), [](std::uint8_t pass) { return pass == 0; });
        if (one_lap) section.passes.clear();
    }
    return sections;
}

core::Result<std::vector<PointSection>> read_points(std::span<const std::string> paths) {
    Sections all;
    for (const auto& path : paths) {
        auto sections = read_points(path);
        if (!sections) return sections;
        for (auto& section : *sections) {
            const bool taken =
                std::any_of(all.begin(), all.end(), [&](const auto& s) { return s.name == section.name; });
            if (taken) section.name = stem(path) + ":" + section.name;
            all.push_back(std::move(section));
        }
    }
    if (all.empty()) return fail(ErrorCode::input_missing, "no points file given");
    return all;
}

}  // namespace cmm::acquisition
