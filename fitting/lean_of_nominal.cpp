// SPDX-License-Identifier: Apache-2.0
#include "fitting/lean_of_nominal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cmm::fitting {

core::Result<SurfaceSection> compensate_by_nominal(const SectionFit& flat, const SectionOptions& options,
                                                   const NominalNormal& nominal) {
    const SmoothCurve& smooth = flat.centres.curve;
    SectionMovement movement;
    for (std::size_t k = 0; k < smooth.curve.spans(); ++k) {
        SurfaceStation s;
        s.t = smooth.curve.breaks()[k];
        const Jet jet = smooth.curve.jet(s.t);
        const Vec2 outward = jet.right_normal();
        s.lean_rad = std::asin(std::clamp(nominal(jet.position, outward).z(), -1.0, 1.0));
        s.doubt(options.ball_radius_mm, std::numeric_limits<double>::infinity());
        movement.shift.push_back(-s.offset_error_mm * outward);
        movement.stations.push_back(s);
    }
    return move_section(smooth, std::move(movement), flat, options);
}

}  // namespace cmm::fitting
