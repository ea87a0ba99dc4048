// SPDX-License-Identifier: Apache-2.0
#include "sim/section_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "core/text.hpp"
#include "sim/profiles.hpp"

namespace cmm::sim {

using core::ErrorCode;
using core::fail;
using core::Result;
using core::Status;

namespace {

constexpr double closing_mm = 1e-4;  // a tenth of a micrometre: files round
constexpr double plane_mm = 0.01;    // heights nearer than this are one plane

std::string lower(std::string_view text) {
    std::string copy(text);
    std::transform(copy.begin(), copy.end(), copy.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return copy;
}

/// The number right after the last `mark` in a text: "z=" in a comment, "_z" in a file name.
std::optional<double> number_after(std::string_view text, std::string_view mark) {
    const auto at = text.rfind(mark);
    if (at == std::string_view::npos) return std::nullopt;
    const std::string_view rest = core::trim(text.substr(at + mark.size()));
    double value = 0.0;
    const auto [end, code] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (code != std::errc{} || !std::isfinite(value)) return std::nullopt;
    return value;
}

char separator_of(std::string_view line) {
    if (line.find(',') != std::string_view::npos) return ',';
    return line.find(';') != std::string_view::npos ? ';' : ' ';  // ' ' splits at tabs too
}

/// Reads a file line by line into profiles.
class SectionReader {
  public:
    explicit SectionReader(const std::string& name)
        : name_(name), z_(number_after(lower(std::filesystem::path(name).stem().string()), "_z")) {
        const std::string extension = lower(std::filesystem::path(name).extension().string());
        turbogrid_ = extension == ".crv" || extension == ".curve";
    }

    Status line(std::string_view text) {
        ++line_;
        start_ = text.data();
        const auto hash = text.find('#');
        if (hash != std::string_view::npos) comment(text.substr(hash + 1));
        const std::string_view data = core::trim(text.substr(0, hash));
        if (data.empty()) return {};
        const auto fields = core::split(data, separator_of(data));
        if (!begun_) {
            begun_ = true;
            const bool names =
                std::none_of(fields.begin(), fields.end(), [](auto f) { return core::parse_number(f).has_value(); });
            if (names) return header(fields);
            if (fields.size() >= 2) columns_ = std::min<std::size_t>(fields.size(), 5);
            if (columns_ == 2) place_[2].reset();
            if (columns_ < 5) place_[4].reset();
            if (columns_ < 4) place_[3].reset();
        }
        return row(fields);
    }

    Result<std::vector<Points>> finish() {
        std::vector<Points> found;
        for (auto& profile : profiles_) {
            auto& p = profile;
            while (p.size() > 1 && (p.back() - p.front()).norm() < closing_mm)
                p.pop_back();
            if (!p.empty()) found.push_back(std::move(p));
        }
        if (found.empty()) return fail(ErrorCode::input_invalid, name_ + ": no points in it");
        if (found.size() == 1 && !place_[3]) found = by_height(std::move(found.front()));
        for (std::size_t k = 0; k < found.size(); ++k) {
            if (found[k].size() >= least_profile_points) continue;
            return fail(ErrorCode::input_invalid, name_ + ": profile " + std::to_string(k + 1) + " has " +
                                                      std::to_string(found[k].size()) + " points; it needs at least " +
                                                      std::to_string(least_profile_points));
        }
        return found;
    }

  private:
    tl::unexpected<core::Error> bad(std::string_view field, const std::string& what) const {
        const auto column = field.data() == nullptr ? 1 : field.data() - start_ + 1;
        return fail(ErrorCode::input_invalid,
                    name_ + ":" + std::to_string(line_) + ":" + std::to_string(column) + ": " + what);
    }

    void comment(std::string_view text) {
        const std::string words = lower(text);
        if (const auto z = number_after(words, "z=")) z_ = z;
        if (turbogrid_ && words.find("profile") != std::string::npos) profiles_.emplace_back();
    }

    Status header(const std::vector<std::string_view>& fields) {
        constexpr std::array<std::string_view, 5> names{"x", "y", "z", "section", "flag"};
        std::array<std::optional<std::size_t>, 5> place;
        for (std::size_t i = 0; i < fields.size(); ++i) {
            const std::string name = lower(fields[i]);
            for (std::size_t k = 0; k < names.size(); ++k) {
                if (name == names[k] || (k < 3 && name == std::string(names[k]) + "_mm")) place[k] = i;
            }
            if (name.size() > 2 && name[0] >= 'x' && name[0] <= 'z' && name[1] == '_' &&
                name != name.substr(0, 1) + "_mm") {
                return bad(fields[i], "column '" + std::string(fields[i]) +
                                          "': coordinates are in millimetres (x_mm, y_mm, z_mm)");
            }
        }
        if (!place[0] || !place[1]) return bad(fields.front(), "the header names no columns x and y");
        place_ = place;
        columns_ = 0;
        for (const auto& column : place_)
            columns_ = std::max(columns_, column ? *column + 1 : 0);
        return {};
    }

    Status row(const std::vector<std::string_view>& fields) {
        if (fields.size() < columns_ || fields.size() < 2) {
            return bad(fields.back(), std::to_string(fields.size()) + " columns where " +
                                          std::to_string(std::max<std::size_t>(2, columns_)) + " are needed");
        }
        Eigen::Vector3d p = Eigen::Vector3d::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
            if (!place_[k]) continue;
            const auto field = fields[*place_[k]];
            const auto value = core::parse_number(field);
            if (!value)
                return bad(field, std::string(1, static_cast<char>('x' + k)) + " is not a number: '" +
                                      std::string(field.substr(0, 40)) + "'");
            p[static_cast<Eigen::Index>(k)] = *value;
        }
        if (!place_[2]) {
            if (!z_)
                return bad(fields[0],
                           "two columns and no height: put z=<number> in a comment or _z<number> in the file name");
            p.z() = *z_;
        }
        if (place_[4]) {
            const auto flag = fields[*place_[4]];
            const auto value = core::parse_number(flag);
            if (!flag.empty() && !value)
                return bad(flag, "flag is not a number: '" + std::string(flag.substr(0, 40)) + "'");
            if (value && *value != 0.0) return {};
        }
        profile_for(place_[3] ? std::string(fields[*place_[3]]) : std::string()).push_back(p);
        return {};
    }

    Points& profile_for(const std::string& section) {
        if (place_[3]) {
            const auto [known, added] = by_name_.try_emplace(section, profiles_.size());
            if (added) profiles_.emplace_back();
            return profiles_[known->second];
        }
        if (profiles_.empty()) profiles_.emplace_back();
        return profiles_.back();
    }

    /// One list of points that steps through planes of constant height, along any axis, is as many profiles.
    static std::vector<Points> by_height(Points all) {
        for (const Eigen::Index axis : {2, 1, 0}) {
            std::vector<Points> planes;
            for (const auto& p : all) {
                if (planes.empty() || std::abs(p[axis] - planes.back().front()[axis]) > plane_mm) planes.emplace_back();
                planes.back().push_back(p);
            }
            const bool all_large = std::all_of(planes.begin(), planes.end(),
                                               [](const Points& p) { return p.size() >= least_profile_points; });
            if (planes.size() < 2 || !all_large) continue;
            for (auto& plane : planes) {
                if ((plane.back() - plane.front()).norm() < closing_mm) plane.pop_back();
            }
            return planes;
        }
        return {std::move(all)};
    }

    const std::string& name_;
    std::optional<double> z_;
    bool turbogrid_ = false, begun_ = false;
    const char* start_ = nullptr;
    std::size_t line_ = 0;
    std::size_t columns_ = 0;
    std::array<std::optional<std::size_t>, 5> place_{0, 1, 2, 3, 4};  // of x, y, z, section, flag
    std::vector<Points> profiles_;
    std::map<std::string, std::size_t> by_name_;
};

/// The axis along which the profiles' centres are spread most.
char widest_axis(const std::vector<Points>& profiles) {
    Eigen::Vector3d low = mean_of(profiles.front()), high = low;
    for (const auto& profile : profiles) {
        low = low.cwiseMin(mean_of(profile));
        high = high.cwiseMax(mean_of(profile));
    }
    Eigen::Index axis = 2;
    if ((high - low).maxCoeff(&axis) <= 0.0) axis = 2;
    return static_cast<char>('x' + axis);
}

}  // namespace

Result<std::vector<Points>> parse_sections(std::string_view content, const std::string& name) {
    SectionReader reader(name);
    while (!content.empty()) {
        const std::size_t end = std::min(content.find('\n'), content.size());
        if (auto status = reader.line(content.substr(0, end)); !status) return tl::unexpected(status.error());
        content.remove_prefix(std::min(end + 1, content.size()));
    }
    return reader.finish();
}

Result<std::vector<Points>> read_sections(const std::vector<std::string>& files, const std::string& span) {
    std::vector<Points> all;
    for (const auto& file : files) {
        const auto content = core::read_file(file);
        if (!content) return tl::unexpected(content.error());
        auto some = parse_sections(*content, file);
        if (!some) return tl::unexpected(some.error());
        std::move(some->begin(), some->end(), std::back_inserter(all));
    }
    const char axis = span == "auto" ? widest_axis(all) : span.front();
    for (auto& profile : all) {
        for (auto& p : profile) {
            if (axis == 'y') p = {p.z(), p.x(), p.y()};
            if (axis == 'x') p = {p.y(), p.z(), p.x()};
        }
    }
    return all;
}

}  // namespace cmm::sim
