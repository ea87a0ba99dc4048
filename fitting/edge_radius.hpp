// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "fitting/measured_section.hpp"
#include "fitting/thickness_measures.hpp"

namespace cmm::fitting {

/// The stretch of a contour about an edge's nose that a circle goes through: by the angle that it turns, half of it to
/// either side, or by the straight distance from the nose. One of the two.
struct RadiusWindow {
    std::optional<double> arc_rad, reach_mm;
    bool operator==(const RadiusWindow&) const = default;
};

struct WindowRadius {
    Measure radius;
    double arc_rad = 0.0;  ///< by which the contour turns within the window
    double rms_mm = 0.0;   ///< of the orthogonal distances, with equal steps of arc length
};

/// Radius of the circle of least squared orthogonal distances through a window of an edge. Where the edge is no arc the
/// radius is one of that window. Errors: fit_not_evaluable (the window reaches beyond the edge, it turns by less than
/// 60 degrees).
core::Result<WindowRadius> measure_edge_radius(MeasuredSection& section, EdgeName edge, const RadiusWindow& window);

}  // namespace cmm::fitting
