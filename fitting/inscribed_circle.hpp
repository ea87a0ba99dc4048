// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "fitting/contour_geometry.hpp"

namespace cmm::fitting {

/// The two sides of a section, each from nose to nose, and which is which.
struct SectionSides {
    ContourRange suction, pressure;
    std::size_t le = 0, te = 0;  ///< points of the contour at the noses

    static SectionSides of(const SectionFit& fit, const ContourGeometry& contour);
};

/// A circle that touches both sides from inside, its centre being on the mean camber line.
struct InscribedCircle {
    Vec2 centre = Vec2::Zero();
    double radius = 0.0;
    ContourPlace on_suction, on_pressure;
    Vec2 to_suction = Vec2::UnitY(), to_pressure = -Vec2::UnitY();  ///< unit, from the centre to where it touches

    /// Direction of the camber line there, unit: it halves the angle between the sides. `forward` tells the sense.
    Vec2 along(const Vec2& forward) const;
    /// Growth of the radius along the camber line.
    double growth(const Vec2& forward) const { return -to_suction.dot(along(forward)); }
    /// How far the centre moves along `across`, on a line in that direction, and how the radius changes, times
    /// `weight`.
    void add_shift(const ContourGeometry& contour, const Vec2& across, double weight, Sensitivity& number) const;
    void add_radius(const ContourGeometry& contour, const Vec2& across, double weight, Sensitivity& number) const;
};

/// Finds inscribed circles on given lines across a section: there the distances to the nearest places of both sides are
/// equal, each side searched as a whole, so that a bump or a notch moves the circle no more than it must.
class InscribedCircleFinder {
  public:
    InscribedCircleFinder(const ContourGeometry& contour, const SectionSides& sides)
        : contour_(&contour), sides_(sides) {}

    /// On the line through `start` along `across` (unit, from the pressure to the suction side). Newton's method, held
    /// in a bracket. None: both nearest places lie on the same side of the centre, or there is no such circle.
    std::optional<InscribedCircle> on_line(const Vec2& start, const Vec2& across) const;

  private:
    const ContourGeometry* contour_;
    SectionSides sides_;
};

}  // namespace cmm::fitting
