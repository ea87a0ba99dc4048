// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/nominal.hpp"
#include "core/error.hpp"

namespace cmm::acquisition {

/// A section of a nominal file, in millimetres, points in file order.
struct NomSection {
    std::string name;
    double z_mm = 0.0;
    bool skewed = false;  ///< its points do not lie at one height
    std::vector<Eigen::Vector3d> points_mm, normals;
    std::vector<PointTolerance> tolerances;           ///< by point; empty: the section has none
    std::optional<Eigen::Vector2d> nose_mm, tail_mm;  ///< of two points that it names: their middle
    std::optional<std::array<double, 2>> offsets_mm;  ///< LE, TE
};

struct NomFile {
    bool inches = false;
    std::vector<NomSection> sections;  ///< in file order, at least one
};

/// Reads a nominal file of PC-DMIS Blade (.NOM; Hexagon, PC-DMIS Blade 6.0 help, "Nominal File Keywords" and "Variable
/// Tolerancing"; docs/part-file.md says how it is understood). What we do not have (FORCE, PARTIAL) is an error unless
/// `skip` names it. Errors: input_invalid with file:line:column.
core::Result<NomFile> parse_nom(std::string_view content, const std::string& name, std::span<const std::string> skip);
/// Errors: those of parse_nom, input_missing.
core::Result<NomFile> read_nom(const std::string& path, std::span<const std::string> skip);

}  // namespace cmm::acquisition
