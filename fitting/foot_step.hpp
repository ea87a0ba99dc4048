// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fitting/surface.hpp"

namespace cmm::fitting {

constexpr int most_foot_steps = 20;
/// A longer one is never Newton's last.
constexpr double longest_last_foot_step_mm = 1e-3;

/// Gradient and second derivatives of |S - p|^2 / 2.
struct FootSlope {
    double gu, gv, huu, huv, hvv;
    double euu, euv, evv;  // first fundamental form

    FootSlope(const SurfaceJet& jet, const Vec3& r)
        : gu(jet.du.dot(r)),
          gv(jet.dv.dot(r)),
          huu(0.0),
          huv(0.0),
          hvv(0.0),
          euu(jet.du.squaredNorm()),
          euv(jet.du.dot(jet.dv)),
          evv(jet.dv.squaredNorm()) {
        huu = euu + r.dot(jet.duu);
        huv = euv + r.dot(jet.duv);
        hvv = evv + r.dot(jet.dvv);
        if (!(huu > 0.0 && hvv > 0.0 && huu * hvv - huv * huv > 1e-3 * euu * evv)) huu = euu, huv = euv, hvv = evv;
    }
    /// Squared length of a step on the surface.
    double length(double du, double dv) const { return euu * du * du + 2.0 * euv * du * dv + evv * dv * dv; }
};

struct FootStep {
    double u = 0.0, v = 0.0;
};

/// Whether a step of this squared length is Newton's last where the foot is so far away. It leaves its square times the
/// bend, t, of the way along the surface, which is t of the distance of a point on it and t^2 / 2d of one beside it.
inline bool is_last_foot_step(double squared_step, double squared_distance) {
    constexpr double most_bend_per_mm = 100.0;  // of edges, and of how uneven a surface's parameters are on them
    constexpr double indifferent_rest_mm = 1e-7;
    if (!(squared_step < longest_last_foot_step_mm * longest_last_foot_step_mm)) return false;
    const double rest = most_bend_per_mm * squared_step, squared_rest = rest * rest;
    return rest < indifferent_rest_mm ||
           squared_rest * squared_rest < 4.0 * indifferent_rest_mm * indifferent_rest_mm * squared_distance;
}

/// Newton's step; a direction in which the bound holds it back is left out.
inline FootStep foot_step(const FootSlope& s, bool free_u, bool free_v) {
    if (free_u && free_v) {
        const double det = s.huu * s.hvv - s.huv * s.huv;
        if (!(det > 0.0)) return {};
        return {(s.huv * s.gv - s.hvv * s.gu) / det, (s.huv * s.gu - s.huu * s.gv) / det};
    }
    if (free_u) return {s.huu > 0.0 ? -s.gu / s.huu : 0.0, 0.0};
    if (free_v) return {0.0, s.hvv > 0.0 ? -s.gv / s.hvv : 0.0};
    return {};
}

/// Whether the bound at which a parameter stands keeps it from going down the gradient.
inline bool held_at_bound(double at, double low, double high, double gradient) {
    return (at <= low && gradient > 0.0) || (at >= high && gradient < 0.0);
}

}  // namespace cmm::fitting
