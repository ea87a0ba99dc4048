// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/section.hpp"
#include "fitting/surface_fit.hpp"
#include "fitting/surface_rows.hpp"

namespace cmm::fitting {

/// A point of the part where a ball touched it.
struct ContactPoint {
    Vec3 position_mm = Vec3::Zero();
    Vec3 normal = Vec3::Zero();  ///< unit, out of the material, of the surface (not of the section)
    double lean_rad = 0.0;       ///< of the normal against the section's plane
};

/// The contour of the part in a plane z = const.
struct ContactContour {
    double z_mm = 0.0;
    bool final = false;                ///< a section above it has closed
    std::vector<ContactPoint> points;  ///< counter-clockwise from the LE, all at z_mm
    std::size_t unreached = 0;         ///< places where the ball touches nothing (concave radius below its own)
};

/// Compensation of the ball by the surface of its centres (seed 000, A6; the equidistant surface): sections of ball
/// centres come one after another, upwards; contact = centre - r N, N the normal of the surface through all of them;
/// the contour asked for is cut from the surface of contacts in its own plane. A section is provisional until the one
/// above it has closed: its lean then rests on the sections below alone. One owner, one thread. Millimetres, part
/// frame.
class SurfaceCompensation {
  public:
    /// `newest`: of so many sections at most, the last ones, the surface is made, and they are settled in fewer rounds,
    /// as more are to come (0: of all).
    explicit SurfaceCompensation(double ball_radius_mm, std::size_t newest = 0)
        : ball_radius_(ball_radius_mm), newest_(newest) {}

    /// Takes the centres of a section in measuring order and finds the bad points; `fit` has to follow. A section that
    /// is refused leaves all as it was. Errors: fit_not_evaluable (the section's own, see fit_section; not above the
    /// last one; does not continue it; ball radius not a number).
    core::Status add(std::span<const Vec2> centres, double z_mm, const SectionOptions& options = {});
    /// The same with a curve of centres that is there already.
    core::Status add(SmoothCurve centres, double z_mm, const std::optional<Vec2>& le_hint = {},
                     const std::optional<Vec2>& te_hint = {});

    /// Lays the surface through the sections: O(their number), some 30 ms for 25, half of that while it grows. Errors:
    /// those of fit_surface.
    core::Status fit();

    /// The part's contour at a height between the first and the last section, about `count` points: three quarters by
    /// length, the others by turning. Errors: fit_not_evaluable (no surface: see `fit`; a height beyond the sections).
    core::Result<ContactContour> contour(double z_mm, std::size_t count = 2400) const;

    /// As the surface has them, settled (settle_rows); none before the first `fit`.
    std::span<const SurfaceRow> rows() const { return rows_; }
    /// None until `fit`, and again from the next section on.
    const std::optional<SurfaceFit>& centres() const { return fit_; }

  private:
    double ball_radius_ = 0.0;
    std::size_t newest_ = 0;
    std::vector<SurfaceRow> own_, rows_;  // as they came, and for the surface
    std::optional<SurfaceFit> fit_;
};

}  // namespace cmm::fitting
