// SPDX-License-Identifier: Apache-2.0
#include "fitting/stray_points.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "fitting/closed_curve.hpp"
#include "fitting/displaced_row.hpp"
#include "fitting/outliers.hpp"
#include "fitting/surface_cut.hpp"

namespace cmm::fitting {
namespace {

constexpr double steep_share = 0.3;           // of the farthest of a run
constexpr std::size_t shorter_than_dent = 3;  // so many points of a dent do not show its flanks
constexpr std::size_t parts_of_a_level_span = 4;
constexpr double good_sigmas = 3.0;  // off what the others foretell, by its own noise

/// May be good or bad.
bool is_open(const PointVerdict& verdict) {
    return !verdict.kept && (verdict.reason == RejectReason::none || is_left_out(verdict));
}

/// Where a section strays.
struct StrayPlace {
    Vec2 position;
    double reach_mm, most_mm;
};

std::vector<StrayPlace> places_on(const SurfaceFit& fit, std::size_t row, double z_mm) {
    std::vector<StrayPlace> places;
    for (const Stray& stray : fit.strays)
        if (stray.row == row)
            places.push_back({fit.surface.position({stray.u, z_mm}).head<2>(), stray.reach_mm, stray.most_mm});
    return places;
}

/// Of the place that a foot is near to, if it is near to one: farther off a good point is not.
std::optional<double> most_off(std::span<const StrayPlace> places, const Vec2& foot) {
    std::optional<double> most;
    double nearest = 0.0;
    for (const StrayPlace& place : places) {
        const double squared = (place.position - foot).squaredNorm();
        if (squared > place.reach_mm * place.reach_mm || (most && squared >= nearest)) continue;
        most = place.most_mm;
        nearest = squared;
    }
    return most;
}

/// All of a run of points that are off, unless they are too many, or some of more than three far less than the
/// farthest: a dent has flanks.
void take_run(std::span<const StrayPoint> run, std::vector<StrayPoint>& taken) {
    double farthest = 0.0;
    for (const StrayPoint& point : run)
        farthest = std::max(farthest, std::abs(point.off_mm));
    const bool steep = std::all_of(run.begin(), run.end(), [&](const StrayPoint& point) {
        return std::abs(point.off_mm) > steep_share * farthest;
    });
    if (run.size() <= (steep ? longest_bad_run : shorter_than_dent)) taken.insert(taken.end(), run.begin(), run.end());
}

}  // namespace

StrayPoints stray_points(const SurfaceCompensation& surface, double z_mm, std::span<const Vec2> centres,
                         std::span<const PointVerdict> verdicts) {
    const auto rows = surface.rows();
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.z_mm() == z_mm; });
    if (!surface.centres() || row == rows.end()) return {};
    const SurfaceFit& fit = *surface.centres();
    const auto places = places_on(fit, static_cast<std::size_t>(row - rows.begin()), z_mm);
    if (places.empty() && std::none_of(verdicts.begin(), verdicts.end(), is_left_out)) return {};
    std::vector<Vec2> level;
    for (const double u : span_parameters(fit.surface.u(), parts_of_a_level_span))
        level.push_back(fit.surface.position({u, z_mm}).head<2>());
    const auto curve = ClosedCurve::through(level);
    if (!curve || displacement_of(row->smooth(), *curve)) return {};
    std::vector<std::size_t> open;
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < centres.size(); ++i) {
        if (!is_open(verdicts[i])) continue;
        open.push_back(i);
        points.push_back(centres[i]);
    }
    std::vector<ClosestPoint> feet(points.size());
    curve->closest(points, feet);
    // Along the curve: what was measured twice is one run.
    std::vector<std::size_t> along(open.size());
    std::iota(along.begin(), along.end(), std::size_t{0});
    std::sort(along.begin(), along.end(), [&](std::size_t a, std::size_t b) { return feet[a].s_mm < feet[b].s_mm; });
    // The rows' curves scatter less than their points.
    const double good_mm = good_sigmas * row->smooth().sigma_mm;
    std::vector<std::optional<double>> most(open.size());
    for (std::size_t k = 0; k < open.size(); ++k)
        most[k] = most_off(places, feet[k].foot);
    const auto is_good = [&](std::size_t k) {
        return std::abs(feet[k].distance_mm) <= std::max(most[k].value_or(0.0), good_mm);
    };
    const auto is_off = [&](std::size_t k) { return most[k] && !is_good(k); };
    StrayPoints found;
    for (std::size_t k = 0; k < open.size(); ++k)
        if (is_left_out(verdicts[open[k]]) && is_good(k)) found.good.push_back({open[k], feet[k].distance_mm});
    const auto first = std::find_if_not(along.begin(), along.end(), is_off);
    std::rotate(along.begin(), first, along.end());
    std::vector<StrayPoint> run;
    for (const std::size_t k : along) {
        if (is_off(k)) {
            run.push_back({open[k], feet[k].distance_mm});
            continue;
        }
        take_run(run, found.bad);
        run.clear();
    }
    take_run(run, found.bad);
    return found;
}

}  // namespace cmm::fitting
