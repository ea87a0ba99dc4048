// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace cmm::fitting {

/// A joint of the curvature on a row.
struct RowJoint {
    double s_mm = 0.0;      ///< arc length: where the row's own points have it ...
    double sigma_mm = 0.0;  ///< ... and the standard deviation of that
    double step = 0.0;      ///< of the curvature, 1/mm
};

/// What of a closed row corresponds to the other rows. Arc lengths in mm from the start of its curve.
struct RowFeatures {
    /// Counter-clockwise from the LE: its nose, its end; the TE's beginning, nose and end; the LE's beginning.
    static constexpr std::size_t count = 6;
    enum Feature : std::size_t { le_nose, le_end, te_begin, te_nose, te_end, le_begin };

    double z_mm = 0.0, length_mm = 0.0;
    std::array<double, count> s_mm{};
    /// Where the curvature jumps beside that end of an edge; none at noses.
    std::array<std::optional<RowJoint>, count> joints;

    /// Beside an end of an edge, on its side of the nose, the joint with the largest step counts. It may be farther
    /// from the nose than the end is: an ellipse's curvature falls long before it meets the side. One that a fit tells
    /// no number of does not count.
    void set_joints(std::span<const RowJoint> found);
};

}  // namespace cmm::fitting
