// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

/// The files of the contract, read by code of their own: a reader in a customer's plant would do the same.
namespace cmm::test {

std::vector<nlohmann::json> read_ndjson(const std::string& path);

/// A CSV file with a header: rows of named fields.
std::vector<std::map<std::string, std::string>> read_csv(const std::string& path);

struct ContourRow {
    Eigen::Vector3d position_mm;
    Eigen::Vector3d normal;
    std::string zone;
    double u95_mm;
};
std::vector<ContourRow> read_contour(const std::string& path);

/// Distance of a point to a closed polyline, by brute force.
double distance_to_polyline(const Eigen::Vector2d& point, const std::vector<Eigen::Vector2d>& closed);

/// Signed area of a closed polyline; positive: counter-clockwise.
double signed_area(const std::vector<Eigen::Vector2d>& closed);

}  // namespace cmm::test
