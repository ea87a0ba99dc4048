// SPDX-License-Identifier: Apache-2.0
#include "tests/support/outputs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace cmm::test {

std::vector<nlohmann::json> read_ndjson(const std::string& path) {
    std::vector<nlohmann::json> events;
    std::ifstream in(path);
    for (std::string line; std::getline(in, line);)
        events.push_back(nlohmann::json::parse(line));
    return events;
}

std::vector<std::map<std::string, std::string>> read_csv(const std::string& path) {
    std::ifstream in(path);
    std::vector<std::string> names;
    std::vector<std::map<std::string, std::string>> rows;
    for (std::string line; std::getline(in, line);) {
        if (line.empty() || line.front() == '#') continue;
        std::vector<std::string> fields;
        std::stringstream stream(line);
        for (std::string field; std::getline(stream, field, ',');)
            fields.push_back(field);
        if (line.back() == ',') fields.emplace_back();
        if (names.empty()) {
            names = fields;
            continue;
        }
        EXPECT_EQ(fields.size(), names.size()) << path << ": " << line;
        std::map<std::string, std::string> row;
        for (std::size_t i = 0; i < std::min(names.size(), fields.size()); ++i)
            row[names[i]] = fields[i];
        rows.push_back(std::move(row));
    }
    return rows;
}

std::vector<ContourRow> read_contour(const std::string& path) {
    std::vector<ContourRow> rows;
    for (const auto& row : read_csv(path)) {
        ContourRow point;
        point.position_mm = {std::stod(row.at("x_mm")), std::stod(row.at("y_mm")), std::stod(row.at("z_mm"))};
        point.normal = {std::stod(row.at("nx")), std::stod(row.at("ny")), std::stod(row.at("nz"))};
        point.zone = row.at("zone");
        point.u95_mm = std::stod(row.at("u95_mm"));
        rows.push_back(std::move(point));
    }
    return rows;
}

double distance_to_polyline(const Eigen::Vector2d& point, const std::vector<Eigen::Vector2d>& closed) {
    double best = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < closed.size(); ++i) {
        const Eigen::Vector2d& a = closed[i];
        const Eigen::Vector2d ab = closed[(i + 1) % closed.size()] - a;
        const double t = ab.squaredNorm() > 0.0 ? std::clamp((point - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
        best = std::min(best, (point - a - t * ab).squaredNorm());
    }
    return std::sqrt(best);
}

double signed_area(const std::vector<Eigen::Vector2d>& closed) {
    double twice = 0.0;
    for (std::size_t i = 0; i < closed.size(); ++i) {
        const auto& a = closed[i];
        const auto& b = closed[(i + 1) % closed.size()];
        twice += a.x() * b.y() - a.y() * b.x();
    }
    return 0.5 * twice;
}

}  // namespace cmm::test
