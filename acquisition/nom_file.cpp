// SPDX-License-Identifier: Apache-2.0
#include "acquisition/nom_file.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/keyword_file.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

constexpr double largest_coordinate_mm = 1e5;
constexpr double same_height_mm = 1e-3;
constexpr double rounded_normal = 0.1;  // a unit vector of few digits
constexpr std::size_t fewest_of_section = 8, most_of_section = 1000000, most_nom_sections = 10000;

/// An end as NOSE or TAIL names it: points counted from 1.
struct NamedEnd {
    std::vector<std::size_t> points;
    const KeywordLine* line = nullptr;
};

class NomReader {
  public:
    NomReader(const KeywordFile& file, std::span<const std::string> skip) : file_(file), skip_(skip) {}

    core::Result<NomFile> read() {
        while (at_ < file_.lines().size()) {
            if (auto status = line(); !status) return tl::unexpected(status.error());
        }
        const auto& last = file_.lines().back();
        if (!units_) return file_.wrong(last, 0, "the file has no line UNITS INCH or UNITS MM");
        if (!announced_) return file_.wrong(last, 0, "the file has no line NUM_SECT with the number of sections");
        if (*announced_ != nom_.sections.size())
            return file_.wrong(last, 0,
                               "NUM_SECT says " + std::to_string(*announced_) + " sections, the file has " +
                                   std::to_string(nom_.sections.size()));
        return std::move(nom_);
    }

  private:
    core::Status line() {
        const KeywordLine& line = file_.lines()[at_];
        const std::string keyword = line.keyword();
        if (keyword == "SECTION") return section();
        ++at_;
        if (keyword == "UNITS") {
            const auto inches = file_.inches(line);
            if (!inches) return tl::unexpected(inches.error());
            if (!nom_.sections.empty()) return file_.wrong(line, 0, "UNITS must stand before the first SECTION");
            if (units_ && nom_.inches != *inches) return file_.wrong(line, 1, "UNITS says something else than before");
            nom_.inches = *inches;
            units_ = true;
            scale_ = *inches ? mm_of_inch : 1.0;
            return {};
        }
        if (keyword == "NUM_SECT") {
            const auto count = file_.count(line, 1, "NUM_SECT", 1, most_nom_sections);
            if (!count) return tl::unexpected(count.error());
            announced_ = *count;
            return file_.at_most(line, 2);
        }
        if (core::parse_number(line.cells.front().text))
            return file_.wrong(line, 0,
                               nom_.sections.empty()
                                   ? "a point before the first SECTION"
                                   : "more points than SECTION " + nom_.sections.back().name + " says");
        static constexpr std::array<std::string_view, 6> words{"UNITS", "NUM_SECT", "SECTION",
                                                               "NOSE",  "TAIL",     "OFFSETS"};
        const auto near = core::nearest_word(keyword, words);
        return file_.wrong(line, 0,
                           "'" + std::string(line.cells.front().text.substr(0, 40)) + "' does not belong here" +
                               (near ? "; did you mean " + *near + "?" : ""));
    }

    core::Status section() {
        const KeywordLine& head = file_.lines()[at_++];
        if (!units_) return file_.wrong(head, 0, "UNITS INCH or UNITS MM must stand before the first SECTION");
        if (head.cells.size() < 4) return file_.wrong(head, 9, "SECTION needs a name, a number of points and a height");
        NomSection section;
        section.name = std::string(head.cells[1].text);
        for (const auto& other : nom_.sections)
            if (other.name == section.name)
                return file_.wrong(head, 1, "a second section of the name '" + section.name + "'");
        const auto count = file_.count(head, 2, "the number of points", fewest_of_section, most_of_section);
        if (!count) return tl::unexpected(count.error());
        const auto z = coordinate(head, 3, "the height");
        if (!z) return tl::unexpected(z.error());
        section.z_mm = *z;
        for (std::size_t k = 4; k < head.cells.size(); ++k) {
            const std::string word = in_capitals(head.cells[k].text);
            if (word == "SKEWED") section.skewed = true;
            // I marks the section that the other program shows first.
            if (word != "SKEWED" && word != "I")
                return file_.wrong(head, k,
                                   "'" + std::string(head.cells[k].text.substr(0, 40)) + "' is neither I nor SKEWED");
        }
        NamedEnd nose, tail;
        for (; at_ < file_.lines().size(); ++at_) {
            const KeywordLine& line = file_.lines()[at_];
            const std::string keyword = line.keyword();
            core::Status status;
            if (keyword == "NOSE")
                status = end(line, *count, nose);
            else if (keyword == "TAIL")
                status = end(line, *count, tail);
            else if (keyword == "OFFSETS")
                status = offsets(line, section);
            else
                break;
            if (!status) return status;
        }
        if (auto status = rows(head, *count, section); !status) return status;
        section.nose_mm = middle_of(nose, section);
        section.tail_mm = middle_of(tail, section);
        if (nose.line != nullptr && tail.line != nullptr &&
            (*section.nose_mm - *section.tail_mm).norm() < same_height_mm)
            return file_.wrong(*tail.line, 1, "NOSE and TAIL are at one place");
        nom_.sections.push_back(std::move(section));
        return {};
    }

    core::Result<double> coordinate(const KeywordLine& line, std::size_t field, std::string_view what) const {
        const auto value = file_.number(line, field, what);
        if (!value) return value;
        if (std::abs(*value) * scale_ <= largest_coordinate_mm) return *value * scale_;
        return file_.wrong(line, field, std::string(what) + " is more than 100 m from the origin");
    }

    core::Status end(const KeywordLine& line, std::size_t count, NamedEnd& end) const {
        if (end.line != nullptr) return file_.wrong(line, 0, "a second " + line.keyword() + " of this section");
        end.line = &line;
        for (std::size_t k = 1; k < line.cells.size(); ++k) {
            const std::string word = in_capitals(line.cells[k].text);
            if (word == "SQUARE") continue;  // the form of an edge is told by its points
            if (word == "FORCE" || word == "PARTIAL") {
                if (lists_word(skip_, word)) continue;
                return file_.wrong(
                    line, k,
                    word == "FORCE" ? "FORCE: where the camber line ends is found from the contour; to go on without "
                                      "it, name it in skip of [nominal]"
                                    : "PARTIAL: open ends are not measured; give the closed contour, and name "
                                      "PARTIAL in skip of [nominal]");
            }
            if (end.points.size() == 2 || !core::parse_number(line.cells[k].text))
                return file_.wrong(line, k,
                                   "'" + std::string(line.cells[k].text.substr(0, 40)) +
                                       "': one or two points are followed by FORCE, SQUARE or PARTIAL");
            const auto point = file_.count(line, k, "the point", 1, count);
            if (!point) return tl::unexpected(point.error());
            end.points.push_back(*point);
        }
        if (end.points.empty()) return file_.wrong(line, 0, line.keyword() + " names no point");
        return {};
    }

    core::Status offsets(const KeywordLine& line, NomSection& section) const {
        std::array<double, 2> found{};
        for (std::size_t k = 0; k < 2; ++k) {
            const auto value = coordinate(line, k + 1, k == 0 ? "LE_OFFSET" : "TE_OFFSET");
            if (!value) return tl::unexpected(value.error());
            if (*value <= 0.0) return file_.wrong(line, k + 1, "an offset must be above 0");
            found[k] = *value;
        }
        section.offsets_mm = found;
        return file_.at_most(line, 3);
    }

    core::Status rows(const KeywordLine& head, std::size_t count, NomSection& section) {
        for (std::size_t i = 0; i < count; ++i, ++at_) {
            const bool ends = at_ >= file_.lines().size() || file_.lines()[at_].keyword() == "SECTION";
            if (ends)
                return file_.wrong(head, 2,
                                   "section " + section.name + " has " + std::to_string(i) + " points where it says " +
                                       std::to_string(count));
            if (auto status = row(file_.lines()[at_], section); !status) return status;
        }
        return {};
    }

    core::Status row(const KeywordLine& line, NomSection& section) const {
        const std::size_t fields = line.cells.size();
        if (fields != 6 && fields != 8)
            return file_.wrong(line, fields,
                               "a point is X Y Z I J K, or X Y Z I J K with minus and plus tolerance, found " +
                                   std::to_string(fields) + " fields");
        Eigen::Vector3d point, normal;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto value = coordinate(line, k, std::string(1, "XYZ"[k]));
            if (!value) return tl::unexpected(value.error());
            point[static_cast<Eigen::Index>(k)] = *value;
            const auto direction = file_.number(line, k + 3, std::string(1, "IJK"[k]));
            if (!direction) return tl::unexpected(direction.error());
            normal[static_cast<Eigen::Index>(k)] = *direction;
        }
        if (!section.skewed && std::abs(point.z() - section.z_mm) > same_height_mm)
            return file_.wrong(
                line, 2,
                "Z is not the height of section " + section.name + "; a section that is not plane has the word SKEWED");
        if (std::abs(normal.norm() - 1.0) > rounded_normal)
            return file_.wrong(line, 3, "I J K is no unit vector: its length is " + core::fixed(normal.norm(), 3));
        if (!section.points_mm.empty() && (fields == 8) != !section.tolerances.empty())
            return file_.wrong(line, 6, "all points of a section have tolerances, or none");
        section.points_mm.push_back(point);
        section.normals.push_back(normal.normalized());
        return fields == 8 ? tolerance(line, section) : core::Status{};
    }

    core::Status tolerance(const KeywordLine& line, NomSection& section) const {
        const auto minus = coordinate(line, 6, "the minus tolerance");
        if (!minus) return tl::unexpected(minus.error());
        const auto plus = coordinate(line, 7, "the plus tolerance");
        if (!plus) return tl::unexpected(plus.error());
        if (*minus > 0.0)
            return file_.wrong(line, 6, "the minus tolerance is a deviation with its sign: it is not above 0");
        if (*plus <= *minus) return file_.wrong(line, 7, "the plus tolerance must be above the minus tolerance");
        if (section.skewed)
            return file_.wrong(line, 6, "tolerances by point of a SKEWED section are not evaluated; take them out");
        section.tolerances.push_back({*minus, *plus});
        return {};
    }

    std::optional<Eigen::Vector2d> middle_of(const NamedEnd& end, const NomSection& section) const {
        if (end.points.empty()) return std::nullopt;
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        for (const std::size_t point : end.points)
            sum += section.points_mm[point - 1].head<2>();
        return sum / static_cast<double>(end.points.size());
    }

    const KeywordFile& file_;
    std::span<const std::string> skip_;
    std::size_t at_ = 0;
    bool units_ = false;
    double scale_ = 1.0;
    std::optional<std::size_t> announced_;
    NomFile nom_;
};

}  // namespace

core::Result<NomFile> parse_nom(std::string_view content, const std::string& name, std::span<const std::string> skip) {
    const auto file = KeywordFile::read(content, name);
    if (!file) return tl::unexpected(file.error());
    return NomReader(*file, skip).read();
}

core::Result<NomFile> read_nom(const std::string& path, std::span<const std::string> skip) {
    const auto content = core::read_file(path);
    if (!content) return tl::unexpected(content.error());
    return parse_nom(*content, path, skip);
}

}  // namespace cmm::acquisition
