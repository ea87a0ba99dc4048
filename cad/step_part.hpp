// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"

/// CAD files through Open CASCADE, which stays behind these headers. A build without it has the same functions, and
/// they say so.
namespace cmm::cad {

/// A closed curve in which a plane z = const cuts a part. Points are put onto the part's own surface by Newton's method
/// (to a nanometre), not taken from an approximation of the cut. Immutable, any thread.
class SectionCurve {
  public:
    struct Point {
        Eigen::Vector2d position_mm;
        Eigen::Vector3d spanwise;  ///< in the surface, across the cut, towards +z
    };
    virtual ~SectionCurve() = default;
    /// A place of the part's surface.
    struct Foot {
        Eigen::Vector3d position_mm;
        Eigen::Vector3d normal;  ///< unit, of either sense
    };
    /// t runs from 0 round to period().
    virtual Point at(double t) const = 0;
    /// Where the surface of the face that is cut at t is nearest to a point beside it, by Newton's method from there on
    /// (seed 001, B12), to a nanometre; beyond the face's border its surface goes on. None: it does not settle.
    virtual std::optional<Foot> closest(const Eigen::Vector3d& point_mm, double t) const = 0;
    virtual double period() const = 0;
    /// Parameters in running order, fine enough to show the shape; the seams between faces are among them.
    virtual const std::vector<double>& coarse() const = 0;

  protected:
    SectionCurve() = default;
    SectionCurve(const SectionCurve&) = default;
    SectionCurve& operator=(const SectionCurve&) = default;
};

/// A solid, or a set of faces, of a STEP file: in millimetres, whatever the file's unit, its span along z. Immutable,
/// any thread.
class StepPart {
  public:
    virtual ~StepPart() = default;
    virtual double z_low_mm() const = 0;
    virtual double z_high_mm() const = 0;
    /// The closed curve round the largest area. Errors: input_invalid (none, or one with a gap: where).
    virtual core::Result<std::unique_ptr<SectionCurve>> cut(double z_mm) const = 0;

  protected:
    StepPart() = default;
    StepPart(const StepPart&) = default;
    StepPart& operator=(const StepPart&) = default;
};

/// `body`: name or number (from 1) of the solid; empty: the only one. A file without solids gives all its faces.
/// `span_axis`: which axis of the file (0, 1, 2) becomes +z, by cyclic exchange. Errors: input_missing, input_invalid
/// (not STEP, nothing in it, no such solid, several and none chosen: their names), config_invalid (built without Open
/// CASCADE).
core::Result<std::shared_ptr<const StepPart>> read_step(const std::string& file, const std::string& body,
                                                        int span_axis);

}  // namespace cmm::cad
