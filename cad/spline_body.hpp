// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace cmm::cad {

/// Where a surface was not measured, by its parameters. u0 >= u1: over the seam; the whole way round when they are the
/// ends of the knots.
struct NetHole {
    double u0 = 0.0, u1 = 0.0, v0 = 0.0, v1 = 0.0;
};

/// The bicubic B-spline surface of a blade: u runs round its sections, v from root to tip. Knots and controls as in
/// fitting::BSpline. A value; mm.
struct SplineNet {
    std::vector<double> knots_u, knots_v;
    bool closed_u = true;
    std::size_t count_u = 0;                ///< controls round a section
    std::vector<Eigen::Vector3d> controls;  ///< (i, j) at j * count_u + i
    std::vector<NetHole> holes;             ///< no face is there
};

enum class BodyForm {
    surface,  ///< the surface alone: a face, or a shell of faces around its holes
    solid,    ///< capped flat at root and tip
};
enum class StepSchema { ap214, ap242 };

struct StepOptions {
    BodyForm form = BodyForm::solid;
    StepSchema schema = StepSchema::ap242;
    std::string name = "blade";    ///< of the product
    std::string description = {};  ///< of the file
};

/// Writes the surface as it is, spline by spline, in millimetres. Errors: fit_not_evaluable (knots and controls that do
/// not belong together; nothing but holes; for a solid: ends that are not plane to 0.1 um, open in u, holes, or what
/// Open CASCADE's checker does not call valid), journal_io (the file cannot be written), config_invalid (built without
/// Open CASCADE).
core::Status write_step(const SplineNet& net, const StepOptions& options, const std::string& file);

/// Writes the solid as triangles (binary STL) that stay within `deflection_mm` of it. Errors: as above.
core::Status write_stl(const SplineNet& net, double deflection_mm, const std::string& file);

}  // namespace cmm::cad
