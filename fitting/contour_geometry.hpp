// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "fitting/section.hpp"
#include "fitting/sensitivity.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// A place on a contour: `share` of the way from point `index` to the next.
struct ContourPlace {
    std::size_t index = 0;
    double share = 0.0;
};

/// Points of a closed contour from `first` on, over the end if need be.
struct ContourRange {
    std::size_t first = 0, count = 0;
};

/// A measured contour as a curve with tangents: between two points the cubic of Hermite that has their places and
/// their normals, so that places are as exact as the points are (2 nm at the usual density), and with the questions
/// that characteristics ask. Refers to the contour, which must outlive it; any thread; mm.
class ContourGeometry {
  public:
    /// At least 8 points, counter-clockwise, with normals and arc lengths.
    explicit ContourGeometry(std::span<const ContourPoint> contour);

    std::size_t size() const { return contour_.size(); }
    std::span<const ContourPoint> points() const { return contour_; }
    const ContourPoint& point(std::size_t i) const { return contour_[i % contour_.size()]; }
    ContourRange whole() const { return {0, contour_.size()}; }
    double perimeter() const { return perimeter_; }

    Vec2 position(const ContourPlace& place) const;
    /// Unit, outward.
    Vec2 normal(const ContourPlace& place) const;
    /// Arc length from the contour's first point.
    double arc(const ContourPlace& place) const;
    std::size_t nearest_point(const Vec2& p) const;

    /// The place of a range that lies farthest in a direction; inside the range its normal is that direction.
    ContourPlace farthest(const Vec2& direction, const ContourRange& range) const;
    /// The place of a range that is nearest to a point; with `near` only the neighbourhood of that place is searched.
    ContourPlace foot(const Vec2& p, const ContourRange& range, const ContourPlace* near = nullptr) const;
    /// Where the range crosses the line through p along `direction`, nearest to p; none: size() as index.
    ContourPlace crossing(const Vec2& p, const Vec2& direction, const ContourRange& range) const;

    /// The displacement of the contour at a place along its normal, times `weight`.
    void add(const ContourPlace& place, double weight, Sensitivity& number) const;
    /// The slope of that displacement along the contour, counter-clockwise, times `weight`.
    void add_slope(const ContourPlace& place, double weight, Sensitivity& number) const;

  private:
    Vec2 tangent(std::size_t i) const { return left_of(contour_[i % contour_.size()].normal); }

    std::span<const ContourPoint> contour_;
    double perimeter_ = 0.0;
};

}  // namespace cmm::fitting
