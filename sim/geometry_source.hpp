// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "sim/parametric.hpp"
#include "sim/surface.hpp"

namespace cmm::sim {

/// Where a part's form comes from: one of the kinds of [nominal] and [actual].
struct GeometrySource {
    enum class Kind : std::uint8_t { parametric, sections, mesh };
    Kind kind = Kind::parametric;
    std::string where;  ///< file:line:column, for messages
    BladeNumbers blade;
    std::vector<std::string> files;
    std::string span = "auto";
    double beyond_mm = 1.0;  ///< how far smooth surfaces go on beyond their ends: a ball radius holds every contact
};

/// How the piece's form departs from it (the thickening apart, which is a matter of distance alone).
struct Deviation {
    double twist_rad = 0.0;
    Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
};

/// The keys of [nominal.blade] and [actual.blade].
BladeNumbers read_blade(const core::ConfigTable& table);

/// Builds the surface; what the user should know about it goes to `remarks`. Errors: input_*, config_invalid.
core::Result<std::shared_ptr<const Surface>> build_surface(const GeometrySource& source, const Deviation& deviation,
                                                           std::vector<std::string>& remarks);

}  // namespace cmm::sim
