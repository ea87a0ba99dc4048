// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace cmm::cad::test {

/// An ellipse: p = centre + cos(t) along + sin(t) across, mm.
struct Ellipse {
    Eigen::Vector3d centre_mm, along_mm, across_mm;
};

/// A body between two ellipses in planes of constant z, ruled at equal t: leaning, tapered and twisted, and the cut at
/// any height is an ellipse that can be written down.
struct EllipticBody {
    Ellipse bottom{{2.0, -1.0, 5.0}, {20.0, 6.0, 0.0}, {-0.6, 2.0, 0.0}};
    Ellipse top{{8.0, 3.0, 65.0}, {15.0, 12.0, 0.0}, {-0.9, 1.0, 0.0}};

    Ellipse at(double z_mm) const;
    /// Signed distance from the ellipse at this height, to first order; exact where it is zero.
    double off_mm(const Eigen::Vector2d& point, double z_mm) const;
    /// Angle between the surface normal and the plane at the point of the ellipse with this t.
    double lean_rad(double z_mm, double t) const;
};

enum class Content { solid, two_solids, stacked_faces, gaping_faces };

/// Writes the body (and, for `two_solids`, a second one beside it) by Open CASCADE. `unit`: "MM", "INCH".
void write_step_file(const std::string& file, const EllipticBody& body, Content content = Content::solid,
                     const char* unit = "MM");

}  // namespace cmm::cad::test
