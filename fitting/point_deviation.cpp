// SPDX-License-Identifier: Apache-2.0
#include "fitting/point_deviation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "fitting/surface_index.hpp"

namespace cmm::fitting {
namespace {

// Feet farther away than so many times the rms of those before are looked for again with proof.
constexpr double doubtful = 3.0;
constexpr double nanometre = 1e-6;

}  // namespace

SurfaceDeviation deviation_of(const Surface& surface, std::span<const Vec3> points, bool warm) {
    SurfaceDeviation result;
    const SurfacePlace middle{0.5 * (surface.u().front() + surface.u().back()),
                              0.5 * (surface.v().front() + surface.v().back())};
    std::optional<SurfaceIndex> index;
    SearchCost cost;
    SurfacePlace last = middle;
    SurfaceSpans near;
    std::vector<double> off;
    off.reserve(points.size());
    double sum = 0.0, squares = 0.0;
    for (const Vec3& p : points) {
        auto foot = newton_foot(surface, p, warm ? last : middle, near, &cost);
        // No foot is farther off than it is away: one as near as the others needs no second look.
        if (off.empty() || !foot || foot->squared * static_cast<double>(off.size()) > doubtful * doubtful * squares) {
            if (!index) index.emplace(surface);
            const SurfaceFoot nearest = index->closest(p, last);
            cost.wrong += foot && std::sqrt(nearest.squared) < std::sqrt(foot->squared) - nanometre;
            foot = nearest;
        }
        last = foot->place;
        const SurfaceJet jet = surface.jet(last);
        sum += (p - jet.position).dot(jet.normal());
        off.push_back(std::sqrt(foot->squared));
        squares += foot->squared;
    }
    result.points = points.size();
    result.newton_steps = cost.steps;
    result.newton_failures = cost.failures;
    result.newton_wrong = cost.wrong;
    if (off.empty()) return result;
    const auto n = static_cast<double>(off.size());
    result.mean_mm = sum / n;
    result.rms_mm = std::sqrt(squares / n);
    std::sort(off.begin(), off.end());
    const auto share = [&](double part) { return off[static_cast<std::size_t>(part * (n - 1.0))]; };
    result.p95_mm = share(0.95);
    result.p99_mm = share(0.99);
    result.max_mm = off.back();
    return result;
}

}  // namespace cmm::fitting
