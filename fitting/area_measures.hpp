// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fitting/measured_section.hpp"

namespace cmm::fitting {

/// Area and centre of a section by Green's theorem on its contour.
struct AreaMeasures {
    Measure area;                    ///< mm^2
    Measure centroid_x, centroid_y;  ///< mm
};
AreaMeasures measure_area(const MeasuredSection& section);

}  // namespace cmm::fitting
