// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/error.hpp"
#include "fitting/inscribed_circle.hpp"

namespace cmm::fitting {

/// A place on the camber line near one of its ends.
struct CamberPlace {
    Vec2 position = Vec2::Zero();
    Vec2 inward = Vec2::UnitX();  ///< unit, along the camber line, away from the end
    Sensitivity across;           ///< of the position along left_of(inward), at a fixed place along the line
};

/// Where the camber line leaves the section: the nose or tail point N. Inside the edge an inscribed circle is the edge
/// itself and the direction of the line is not defined by it, so the line is continued: through the centres of
/// inscribed circles between 2 edge scales and 2 scales + 0.12 perimeters from N a cubic by least squares, beside the
/// arc through them (a straight line, where they lie on one).
class CamberEnd {
  public:
    /// What the cubic stands on: of an arc that turns much, a cubic beside a straight line goes astray.
    struct Arc {
        Vec2 centre = Vec2::Zero();
        double radius = 0.0;  ///< 0: straight, ordinate 0
        double side = 1.0;    ///< of the centre on which the line lies
        double ordinate(double x) const;
        double slope(double x) const;
    };

    const Vec2& point() const { return point_; }
    const ContourPlace& place() const { return place_; }
    const Vec2& inward() const { return inward_; }  ///< unit, direction of the camber line there
    /// How a number changes whose gradient by the place of N is `gradient`.
    void add(const ContourGeometry& contour, const Vec2& gradient, Sensitivity& number) const;

  private:
    friend class CamberLineBuilder;
    friend class CamberLine;
    Eigen::RowVector4d powers(double x) const;
    Eigen::RowVector4d slopes(double x) const;
    double ordinate(double x) const { return arc_.ordinate(x) + powers(x).dot(cubic_); }
    Vec2 on_cubic(double x) const { return origin_ + x * axis_ + ordinate(x) * left_of(axis_); }
    Vec2 direction(double x) const {
        return (axis_ + (arc_.slope(x) + slopes(x).dot(cubic_)) * left_of(axis_)).normalized();
    }
    void add_cubic(const ContourGeometry& contour, double x, double weight, Sensitivity& number) const;

    Vec2 point_ = Vec2::Zero(), inward_ = Vec2::UnitX();
    ContourPlace place_;
    Vec2 by_normal_ = Vec2::Zero(), by_camber_ = Vec2::Zero();  // movement of N by the contour's there and the cubic's
    double x_ = 0.0;                                            // of N in the frame of the cubic
    Vec2 origin_ = Vec2::Zero(), axis_ = Vec2::UnitX();         // axis: into the section
    double first_mm_ = 0.0, unit_mm_ = 1.0;                     // where the circles begin, and the scale of x
    Arc arc_;
    Eigen::Vector4d cubic_ = Eigen::Vector4d::Zero();  // beside the arc
    Eigen::Matrix<double, 4, Eigen::Dynamic> fit_;     // the cubic's coefficients from the centres' ordinates
    std::vector<InscribedCircle> circles_;
    Vec2 across_ = Vec2::UnitY();  // in which the circles were sought
};

/// The mean camber line of a section by inscribed circles (docs/theory.md, section 13): from the thickest part outwards
/// in steps of half a radius at most, each centre on a line across the direction of the last ones, and continued at
/// both ends to the contour. Refers to the contour, which must outlive it. Immutable, any thread; mm.
class CamberLine {
  public:
    /// Errors: fit_not_evaluable (no inscribed circle where the section is thickest, or too few towards an end).
    static core::Result<CamberLine> of(const SectionFit& fit, const ContourGeometry& contour);

    const ContourGeometry& contour() const { return *contour_; }
    const SectionSides& sides() const { return sides_; }
    const CamberEnd& le() const { return le_; }
    const CamberEnd& te() const { return te_; }
    /// From the LE to the TE, as far as circles were found.
    const std::vector<InscribedCircle>& circles() const { return circles_; }
    /// The line from nose to tail, dense enough for 1 um between its points.
    const std::vector<Vec2>& points() const { return points_; }
    double length_mm() const { return length_mm_; }

    /// The largest inscribed circle, where the radius stops growing; its arc length from the nose; and the second
    /// derivative of the radius by arc length, which tells how well the place is known.
    struct Thickest {
        InscribedCircle circle;
        Vec2 along = Vec2::UnitX();  ///< direction of the line there, LE to TE
        double arc_mm = 0.0;
        double bend = 0.0;
    };
    Thickest thickest() const;

    /// The place on the line whose straight distance from the end's point is `distance_mm` (TIPARC). Errors:
    /// fit_not_evaluable (beyond the line's other end).
    core::Result<CamberPlace> at_distance(const CamberEnd& end, double distance_mm) const;

  private:
    friend class CamberLineBuilder;
    CamberLine(const ContourGeometry& contour, const SectionSides& sides)
        : contour_(&contour), sides_(sides), finder_(contour, sides) {}
    Vec2 across(const Vec2& forward, const InscribedCircle& near) const;
    std::optional<InscribedCircle> between(std::size_t k, double share) const;
    double arc_at(std::size_t k, const Vec2& centre) const;

    const ContourGeometry* contour_;
    SectionSides sides_;
    InscribedCircleFinder finder_;
    CamberEnd le_, te_;
    std::vector<InscribedCircle> circles_;
    std::vector<double> arc_mm_;  // of the circles, from the nose
    std::vector<Vec2> points_;
    double length_mm_ = 0.0;
};

}  // namespace cmm::fitting
