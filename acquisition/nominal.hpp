// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "acquisition/part_file.hpp"
#include "acquisition/place_limits.hpp"
#include "core/error.hpp"
#include "fitting/nominal.hpp"

namespace cmm::acquisition {

/// The surface of a nominal beside a plane cut. Immutable, any thread.
class NominalSurface {
  public:
    struct Foot {
        Eigen::Vector3d position_mm;
        Eigen::Vector3d normal;  ///< unit, of either sense
    };
    virtual ~NominalSurface() = default;
    /// Where it is nearest to a point, sought from the place of the cut next to `near_mm` on. None: not found.
    virtual std::optional<Foot> closest(const Eigen::Vector3d& point_mm, const Eigen::Vector2d& near_mm) const = 0;

  protected:
    NominalSurface() = default;
    NominalSurface(const NominalSurface&) = default;
    NominalSurface& operator=(const NominalSurface&) = default;
};

/// The nominal part contour in one plane, closed, counter-clockwise, dense enough for a periodic cubic spline to be
/// true to a fraction of a micrometre where the source is smooth. Part frame, mm.
struct NominalContour {
    double z_mm = 0.0;
    std::vector<Eigen::Vector2d> points;
    /// Largest angle of the surface's normal to this plane (A22), and that at each point, positive where the outward
    /// normal points upwards (none: it is the largest one everywhere, and its sign unknown).
    double lean_rad = 0.0;
    std::vector<double> leans_rad;
    std::shared_ptr<const NominalSurface> surface = {};     ///< of STEP files: the part's own
    std::vector<PointTolerance> tolerances = {};            ///< at each point; empty: the nominal has none
    std::optional<Eigen::Vector2d> le_mm = {}, te_mm = {};  ///< near the edges, where the nominal names them
};

/// The nominal of a part: cut at any height. Immutable, thread-safe. Made by `load_nominal` from sections (lofted),
/// parametric formulas, a mesh or a STEP file.
class Nominal {
  public:
    virtual ~Nominal() = default;
    /// Errors: plan_invalid when z lies outside the nominal, input_invalid when the cut is not one closed contour.
    virtual core::Result<NominalContour> cut(double z_mm) const = 0;
    virtual double z_low_mm() const = 0;
    virtual double z_high_mm() const = 0;

  protected:
    Nominal() = default;
    Nominal(const Nominal&) = default;
    Nominal& operator=(const Nominal&) = default;
};

/// Which edge is which: as the part file says, else as the nominal does.
fitting::NominalOptions edge_hints(const NominalSpec& spec, const NominalContour& contour);

/// nullptr for kind "none". Errors: input_missing, input_invalid, config_invalid.
core::Result<std::shared_ptr<const Nominal>> load_nominal(const NominalSpec& spec);

}  // namespace cmm::acquisition
