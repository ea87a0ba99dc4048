// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "fitting/bspline.hpp"
#include "fitting/cubic_axis.hpp"

namespace cmm::fitting {

using Vec3 = Eigen::Vector3d;

/// A place on a surface.
struct SurfacePlace {
    double u = 0.0, v = 0.0;
};

/// Largest and smallest normal curvature, 1/mm, positive where the surface bends away from its normal (convex, when
/// the normal points out of the material).
struct PrincipalCurvatures {
    double largest = 0.0, smallest = 0.0;
    double mean() const { return 0.5 * (largest + smallest); }
    double gauss() const { return largest * smallest; }
};

/// A point of a surface with its derivatives by the parameters.
struct SurfaceJet {
    Vec3 position, du, dv, duu, duv, dvv;

    /// Unit, du x dv: outward where u runs counter-clockwise seen from +v. Zero where the surface is not regular.
    Vec3 normal() const;
    /// Derivatives of `normal` by u and v (Weingarten).
    std::pair<Vec3, Vec3> normal_derivatives() const;
    PrincipalCurvatures curvatures() const;
};

/// A bicubic tensor product B-spline surface S(u, v): u open or closed (round a blade), v open (along its height).
/// Millimetres, any frame. Immutable value, any thread.
class Surface {
  public:
    Surface() = default;
    /// Control (i, j) is controls[j * u.controls() + i]. Errors: fit_not_evaluable (closed in v, controls of another
    /// number or not finite).
    static core::Result<Surface> make(CubicAxis u, CubicAxis v, std::vector<Vec3> controls);

    /// u is brought into the period (or clamped), v clamped.
    Vec3 position(const SurfacePlace& at) const;
    SurfaceJet jet(const SurfacePlace& at) const;
    /// At many places; fastest when neighbours follow each other. `jets` has room for as many.
    void jets(std::span<const SurfacePlace> places, std::span<SurfaceJet> jets) const;
    /// At a place inside the domain whose spans are known.
    SurfaceJet jet_in(std::size_t span_u, std::size_t span_v, const SurfacePlace& at) const;
    Vec3 position_in(std::size_t span_u, std::size_t span_v, const SurfacePlace& at) const;

    /// The curve u = const, by v; and v = const, by u.
    BSpline<3> curve_along_v(double u) const;
    BSpline<3> curve_along_u(double v) const;

    /// The same surface with one knot more (Boehm 1980, row by row). Errors: as BSpline::with_knot.
    core::Result<Surface> with_knot_u(double u) const;
    core::Result<Surface> with_knot_v(double v) const;

    const CubicAxis& u() const { return u_; }
    const CubicAxis& v() const { return v_; }
    Vec3 control(std::size_t i, std::size_t j) const { return row(j)[i].head<3>(); }

  private:
    using Four = Eigen::Array4d;  // a control and a zero: two vector lanes twice
    const Four* row(std::size_t j) const { return controls_.data() + j * stride_; }
    BSpline<3> row_curve(std::size_t j) const;
    BSpline<3> column_curve(std::size_t i) const;

    CubicAxis u_, v_;
    std::size_t stride_ = 0;  // of a row: the controls, and the first three again when closed
    std::vector<Four> controls_;
};

}  // namespace cmm::fitting
