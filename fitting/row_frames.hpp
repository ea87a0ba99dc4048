// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fitting/row_columns.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// A frame in the plane of each row that turns and moves with the part over z: what is left to change there over the
/// rows is the part's form. A blade of 55 degrees of twist is no cubic over z; seen from such frames it nearly is one,
/// and columns may be smoothed as stiffly as its form bears. Any frames that change smoothly with z would do.
class RowFrames {
  public:
    /// Those of the rows' own coordinates.
    explicit RowFrames(std::size_t rows) : frames_(rows) {}
    /// From the rows' places: turns from row to row of least squares about the mean of the places (Kabsch 1976, in the
    /// plane), added up, and these means, each as smoothed_over the z_k.
    RowFrames(std::span<const double> z, const RowColumns& columns);

    Vec2 into(std::size_t row, const Vec2& place) const { return turned_into(row, place - frames_[row].origin); }
    Vec2 out_of(std::size_t row, const Vec2& place) const {
        const Frame& frame = frames_[row];
        return frame.origin + place.x() * frame.x_axis + place.y() * left_of(frame.x_axis);
    }
    /// A direction.
    Vec2 turned_into(std::size_t row, const Vec2& direction) const {
        const Vec2& x_axis = frames_[row].x_axis;
        return {direction.dot(x_axis), cross(x_axis, direction)};
    }

  private:
    struct Frame {
        Vec2 origin = Vec2::Zero(), x_axis = Vec2::UnitX();
    };
    std::vector<Frame> frames_;
};

}  // namespace cmm::fitting
