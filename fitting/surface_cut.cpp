// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface_cut.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/text.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr int most_cut_steps = 60;
constexpr double rounding = 1e-12;  // of the height, and of 1 mm

/// Height of S + d N above the asked one, and its slope by v.
class Height {
  public:
    Height(const Surface& surface, double distance, double z) : surface_(surface), distance_(distance), z_(z) {}

    double at(const SurfacePlace& place, double& slope) {
        span_u_ = surface_.u().span_of(place.u, span_u_);
        span_v_ = surface_.v().span_of(place.v, span_v_);
        jet_ = surface_.jet_in(span_u_, span_v_, place);
        slope = jet_.dv.z() + distance_ * jet_.normal_derivatives().second.z();
        return jet_.position.z() + distance_ * jet_.normal().z() - z_;
    }
    const SurfaceJet& jet() const { return jet_; }

  private:
    const Surface& surface_;
    double distance_, z_;
    std::size_t span_u_ = 0, span_v_ = 0;
    SurfaceJet jet_;
};

/// None: the plane misses the curve u = const.
std::optional<double> crossing(Height& height, double u, double v, double low, double high) {
    double slope = 0.0;
    const double size = high - low;
    for (int step = 0; step < most_cut_steps; ++step) {
        const double off = height.at({u, v}, slope);
        if (std::abs(off) <= rounding * std::max(1.0, std::abs(size))) return v;
        (off < 0.0 ? low : high) = v;
        double next = v - off / slope;
        if (!(slope > 0.0) || !(next > low && next < high)) {
            const double end = off < 0.0 ? high : low;
            next = next == end || std::abs(end - v) < 1e-9 * size ? end : 0.5 * (low + high);
        }
        if (next == v) return std::abs(off) <= 1e-9 * std::max(1.0, size) ? std::optional(v) : std::nullopt;
        v = next;
    }
    return std::nullopt;
}

}  // namespace

core::Result<PlaneCut> cut_at_height(const Surface& surface, double distance_mm, double z_mm,
                                     std::span<const double> u) {
    Height height(surface, distance_mm, z_mm);
    PlaneCut cut;
    cut.points.reserve(u.size());
    const double low = surface.v().front(), high = surface.v().back();
    double v = 0.5 * (low + high);
    for (const double asked : u) {
        const double at = surface.u().inside(asked);
        double slope = 0.0;
        if (!(height.at({at, low}, slope) <= rounding * high) || !(height.at({at, high}, slope) >= -rounding * high))
            return core::fail(
                ErrorCode::fit_not_evaluable,
                "plane cut: z = " + core::fixed(z_mm, 3) + " mm lies beyond the surface at u = " + core::fixed(at, 3));
        const auto found = crossing(height, at, v, low, high);
        if (!found)
            return core::fail(ErrorCode::fit_not_evaluable,
                              "plane cut: the surface does not rise steadily at u = " + core::fixed(at, 3));
        v = *found;
        const SurfaceJet& jet = height.jet();
        const Vec3 normal = jet.normal();
        const auto [by_u, by_v] = jet.normal_derivatives();
        // The offset keeps its side where the area that it spans with its normal keeps its sign.
        const Vec3 du = jet.du + distance_mm * by_u, dv = jet.dv + distance_mm * by_v;
        const bool folded = !(du.cross(dv).dot(normal) > 0.0);
        cut.folded += folded;
        cut.points.push_back({{at, v}, jet.position + distance_mm * normal, normal, folded});
    }
    return cut;
}

std::vector<double> span_parameters(const CubicAxis& axis, std::size_t parts) {
    std::vector<double> u;
    for (std::size_t k = 0; k < axis.spans(); ++k)
        for (std::size_t p = 0; p < parts; ++p)
            u.push_back(axis.low(k) +
                        (axis.high(k) - axis.low(k)) * static_cast<double>(p) / static_cast<double>(parts));
    if (!axis.closed()) u.push_back(axis.back());
    return u;
}

}  // namespace cmm::fitting
