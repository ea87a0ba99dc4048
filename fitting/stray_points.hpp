// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fitting/compensation.hpp"
#include "fitting/section.hpp"

namespace cmm::fitting {

/// By its own section, which may be wrong.
inline bool is_left_out(const PointVerdict& verdict) {
    return verdict.reason == RejectReason::spline_residual || verdict.reason == RejectReason::fit_residual;
}

/// A point of a section, and how far it lies off what all other sections foretell.
struct StrayPoint {
    std::size_t index = 0;  ///< among the section's points
    double off_mm = 0.0;    ///< signed, outwards
};

/// What all other sections say of a section's points where it strays from them.
struct StrayPoints {
    std::vector<StrayPoint> bad;
    std::vector<StrayPoint> good;  ///< of those that their own section has left out, wherever they are
    bool any() const { return !bad.empty() || !good.empty(); }
};

/// Bad points that nothing in their own section betrays (two or three beside an edge, where the next good one is far),
/// and good ones that it has left out with bad ones beside them: where the section at `z_mm` strays from the surface of
/// ball centres through all sections, those of its `centres` that lie farther off it than the others' scatter allows
/// and than three standard deviations of the section's points, and those that do not; elsewhere, of those left out, the
/// ones within three. Of a run of four or five none may be off by less than three tenths of the farthest, and longer
/// runs are a feature of the part: none of those is taken, and none of a section that lies apart as a rigid whole
/// (displaced_row.hpp). Points that are out already (`verdicts`: no contact, operator, duplicate) or that an operator
/// keeps are passed over. `surface` has been laid; one per input point.
StrayPoints stray_points(const SurfaceCompensation& surface, double z_mm, std::span<const Vec2> centres,
                         std::span<const PointVerdict> verdicts);

}  // namespace cmm::fitting
