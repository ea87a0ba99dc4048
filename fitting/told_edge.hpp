// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace cmm::fitting {

/// A joint of the curvature that something else than the curve tells.
struct ToldJoint {
    double t = 0.0;         ///< parameter of a curve through the same points, within its period
    double sigma_mm = 0.0;  ///< standard deviation of the place
    double step = 0.0;      ///< of the curvature, 1/mm
    double reach_mm = 0.0;  ///< a joint with such a step that the curve shows no farther away is this one
};

/// An edge whose form is told from one joint to the other.
struct ToldEdge {
    ToldJoint begin, end;
    std::function<double(double)> curvature;  ///< of the curve of ball centres by that parameter, 1/mm
};

}  // namespace cmm::fitting
