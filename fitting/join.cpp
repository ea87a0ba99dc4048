// SPDX-License-Identifier: Apache-2.0
#include "fitting/join.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cmm::fitting {
namespace {

constexpr double blend_share = 0.25;
constexpr std::size_t pieces_in_patch = 40;

/// 0 at either end of the patch, 1 between the blends, twice differentiable.
double weight_of(const ArcPatch& patch, double t) {
    const double length = patch.to - patch.from;
    const double x = std::clamp(std::min(t - patch.from, patch.to - t) / (blend_share * length), 0.0, 1.0);
    return x * x * x * (10.0 + x * (6.0 * x - 15.0));
}

}  // namespace

PiecewiseCubic join_arcs(const PiecewiseCubic& curve, std::span<const ArcPatch> patches) {
    if (patches.empty()) return curve;
    const double period = curve.period();
    std::vector<double> at(curve.breaks().begin(), curve.breaks().end() - 1);
    for (const ArcPatch& patch : patches)
        for (std::size_t k = 0; k <= pieces_in_patch; ++k)
            at.push_back(curve.wrap(patch.from + (patch.to - patch.from) * static_cast<double>(k) / pieces_in_patch));
    std::sort(at.begin(), at.end());
    // Breaks closer than this would only make the interpolation worse; the loss is below a nanometre.
    const double least = 1e-5 * period;
    at.erase(std::unique(at.begin(), at.end(), [&](double a, double b) { return b - a < least; }), at.end());
    while (at.size() > 3 && at.front() + period - at.back() < least)
        at.pop_back();

    std::vector<Vec2> points;
    points.reserve(at.size());
    for (const double t : at) {
        Vec2 p = curve.jet(t).position;
        for (const ArcPatch& patch : patches) {
            const double inside = t < patch.from ? t + period : t;
            if (inside < patch.from || inside > patch.to) continue;
            const Vec2 radial = (p - patch.circle.centre).normalized();
            p += weight_of(patch, inside) * (patch.circle.centre + patch.circle.radius * radial - p);
        }
        points.push_back(p);
    }
    at.push_back(at.front() + period);
    return interpolate_periodic(points, std::move(at));
}

}  // namespace cmm::fitting
