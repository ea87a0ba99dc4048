// SPDX-License-Identifier: Apache-2.0
#include "fitting/newton_foot.hpp"

#include <cmath>

#include "fitting/foot_step.hpp"

namespace cmm::fitting {

std::optional<SurfaceFoot> newton_foot(const Surface& surface, const Vec3& p, const SurfacePlace& start,
                                       SurfaceSpans& near, SearchCost* cost) {
    const CubicAxis &axis_u = surface.u(), &axis_v = surface.v();
    SurfacePlace at{axis_u.inside(start.u), axis_v.inside(start.v)};
    auto& [i, j] = near;
    i = axis_u.span_of(at.u, i);
    j = axis_v.span_of(at.v, j);
    for (int step = 0; step < most_foot_steps; ++step) {
        const SurfaceJet jet = surface.jet_in(i, j, at);
        const Vec3 r = jet.position - p;
        const FootSlope slope(jet, r);
        const bool free_u = axis_u.closed() || !held_at_bound(at.u, axis_u.front(), axis_u.back(), slope.gu);
        const FootStep move = foot_step(slope, free_u, !held_at_bound(at.v, axis_v.front(), axis_v.back(), slope.gv));
        if (cost != nullptr) ++cost->steps;
        const SurfacePlace next{axis_u.inside(at.u + move.u), axis_v.inside(at.v + move.v)};
        const bool whole = next.v == at.v + move.v && (axis_u.closed() || next.u == at.u + move.u);
        const double squared = slope.length(move.u, move.v);
        if (!std::isfinite(squared)) break;
        at = next;
        i = axis_u.span_of(at.u, i);
        j = axis_v.span_of(at.v, j);
        if (squared < longest_last_foot_step_mm * longest_last_foot_step_mm && whole) {
            const double away = (surface.position_in(i, j, at) - p).squaredNorm();
            if (is_last_foot_step(squared, away)) return SurfaceFoot{at, away};
        }
    }
    if (cost != nullptr) ++cost->failures;
    return std::nullopt;
}

}  // namespace cmm::fitting
