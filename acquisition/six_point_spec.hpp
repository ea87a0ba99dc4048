// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "core/config.hpp"
#include "fitting/six_points.hpp"

/// The six datum points (RPS) of a part file.
namespace cmm::acquisition {

struct DatumPlace {
    Eigen::Vector3d at_mm = Eigen::Vector3d::Zero();  ///< on the part, nominal frame
    std::optional<Eigen::Vector3d> normal;            ///< unit, out of the material; none: that of the nominal there
};

/// One touch, or the middle of two.
struct DatumSpec : DatumPlace {
    std::optional<DatumPlace> opposite;
};

struct SixPointSpec {
    std::array<DatumSpec, fitting::datum_points> places;
    fitting::SixPointOptions options;
    double largest_condition = fitting::largest_condition_default;
    /// How far above its place a touch begins, and how far below it ends without contact: by so much may the part stand
    /// beside where it is expected.
    double approach_mm = 3.0, search_mm = 3.0;
};

/// The [[alignment.point]] list and its keys of an [alignment] table; nothing where there are no points. Complains of a
/// number of points other than six, and, where every direction is given, of points that do not hold the part.
/// `wanted`: also of none.
std::optional<SixPointSpec> read_six_points(const core::ConfigTable& alignment, bool wanted);

}  // namespace cmm::acquisition
