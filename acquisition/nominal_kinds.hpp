// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "acquisition/nom_file.hpp"
#include "acquisition/nominal.hpp"
#include "acquisition/part_file.hpp"
#include "acquisition/points_file.hpp"
#include "acquisition/triangle_mesh.hpp"

/// The kinds of nominal behind `load_nominal`, one source file each.
namespace cmm::acquisition {

/// Sections as they are where they lie in planes, lofted and cut elsewhere (docs/part-file.md, "Loft").
core::Result<std::shared_ptr<const Nominal>> sections_nominal(std::vector<PointSection> sections, Span span);
/// Sections of a nominal file with normals, tolerances and named ends. Errors: those of sections_nominal.
core::Result<std::shared_ptr<const Nominal>> nom_nominal(NomFile file);
/// The formulas of docs/part-file.md. Errors: config_invalid when no section can be built from the numbers.
core::Result<std::shared_ptr<const Nominal>> parametric_nominal(const ParametricBlade& blade);
/// Plane cuts of a closed triangle mesh.
core::Result<std::shared_ptr<const Nominal>> mesh_nominal(TriangleMesh mesh, Span span);
/// Plane cuts of a solid of a STEP file. Errors: those of cad::read_step.
core::Result<std::shared_ptr<const Nominal>> step_nominal(const std::string& file, const std::string& solid, Span span);

/// Of a nominal that does not name them, which edge leads: the one with the larger radius on average over its height,
/// followed from one height to the next, so that it is the same one everywhere.
std::shared_ptr<const Nominal> with_one_leading_edge(std::shared_ptr<const Nominal> nominal);

/// plan_invalid "z = 12.000 mm lies outside the nominal (15.000 mm to 90.000 mm)", unless z lies inside (to 1 um).
core::Status require_height(double z_mm, double low_mm, double high_mm);
/// The cyclic exchange of axes that makes the span +z; `span` must not be automatic.
Eigen::Vector3d turned_to_z(const Eigen::Vector3d& p, Span span) noexcept;

}  // namespace cmm::acquisition
