// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "acquisition/nominal.hpp"
#include "acquisition/six_point_spec.hpp"
#include "core/error.hpp"
#include "drivers/machine.hpp"
#include "fitting/six_points.hpp"

/// Where the six datum points of a part file are touched. Part frame, mm.
namespace cmm::acquisition {

/// With the directions of the nominal where the part file gives none; such a point is moved onto the nominal. Errors:
/// config_invalid (a point that is not on the nominal, whose direction the nominal does not know; points that do not
/// hold the part).
core::Result<fitting::SixPoints> on_nominal(const SixPointSpec& spec, const Nominal& nominal);

/// The ball's places in contact, in the order of the points, and back from them (of six touches).
std::vector<drivers::PathPoint> datum_touches(const fitting::SixPoints& points, double ball_radius_mm,
                                              double speed_mm_s);
fitting::SixPoints points_touched(std::span<const drivers::PathPoint> touches, double ball_radius_mm);

}  // namespace cmm::acquisition
