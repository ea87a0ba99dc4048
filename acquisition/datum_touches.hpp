// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "acquisition/nominal.hpp"
#include "acquisition/six_point_spec.hpp"
#include "core/error.hpp"
#include "drivers/machine.hpp"
#include "fitting/six_points.hpp"

/// Where the six datum points of a part file are touched. Part frame, mm.
namespace cmm::acquisition {

/// With the directions of the nominal where the part file gives none; such a touch is moved onto the nominal. Errors:
/// config_invalid (one that is not on the nominal, whose direction the nominal does not know; points that do not hold
/// the part).
core::Result<fitting::SixPoints> on_nominal(const SixPointSpec& spec, const Nominal& nominal);

/// Which of the datum points are middles of two touches.
using DatumMiddles = std::array<bool, fitting::datum_points>;
DatumMiddles middles_of(const fitting::SixPoints& points);

/// The ball's places in contact, in the order of fitting::touches_of, and the points back from them.
std::vector<drivers::PathPoint> datum_touches(const fitting::SixPoints& points, double ball_radius_mm,
                                              double speed_mm_s);
fitting::SixPoints points_touched(std::span<const drivers::PathPoint> touches, const DatumMiddles& middles,
                                  double ball_radius_mm);
/// "datum point 3", "the opposite touch of datum point 3"
std::string datum_touch_name(const DatumMiddles& middles, std::size_t touch);

}  // namespace cmm::acquisition
