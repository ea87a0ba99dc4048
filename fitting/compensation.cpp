// SPDX-License-Identifier: Apache-2.0
#include "fitting/compensation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/centre_curve.hpp"
#include "fitting/cyclic.hpp"
#include "fitting/settled_rows.hpp"
#include "fitting/surface_cut.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr double contour_turning_share = 0.25;
constexpr std::size_t fewest_points = 16;
constexpr int growing_rounds = 3;

/// Many rows know together in a few rounds what few rows know in eight.
int rounds_for(std::size_t rows) {
    return static_cast<int>(std::clamp<std::size_t>(256 / rows, 2, 8));
}

/// Parameters at which S - r N is cut: in equal steps of length and turning of a first, coarser cut.
std::vector<double> spread(const PlaneCut& cut, double period, std::size_t count) {
    const std::size_t n = cut.points.size();
    std::vector<double> length(n + 1, 0.0), turn(n + 1, 0.0);
    for (std::size_t k = 0; k < n; ++k) {
        const CutPoint &a = cut.points[k], &b = cut.points[cyclic(k + 1, n)];
        length[k + 1] = length[k] + (b.position - a.position).norm();
        turn[k + 1] = turn[k] + std::abs(turn_angle(a.normal.head<2>(), b.normal.head<2>()));
    }
    std::vector<double> u;
    std::size_t k = 0;
    const auto measure = [&](std::size_t i) {
        return (1.0 - contour_turning_share) * length[i] / length[n] + contour_turning_share * turn[i] / turn[n];
    };
    for (std::size_t i = 0; i < count; ++i) {
        const double wanted = static_cast<double>(i) / static_cast<double>(count);
        while (k + 1 < n && measure(k + 1) <= wanted)
            ++k;
        const double from = cut.points[k].place.u;
        const double to = k + 1 < n ? cut.points[k + 1].place.u : cut.points[0].place.u + period;
        const double low = measure(k), high = measure(k + 1);
        u.push_back(from + (high > low ? (wanted - low) / (high - low) : 0.0) * (to - from));
    }
    return u;
}

core::Result<PlaneCut> touched_cut(const Surface& surface, double distance_mm, double z_mm, std::span<const double> u) {
    auto cut = cut_at_height(surface, distance_mm, z_mm, u);
    if (cut) std::erase_if(cut->points, [](const CutPoint& p) { return p.folded; });
    return cut;
}

}  // namespace

core::Status SurfaceCompensation::add(std::span<const Vec2> centres, double z_mm, const SectionOptions& options) {
    auto curve = fit_centre_curve(centres, {}, options);
    if (!curve) return tl::unexpected(curve.error());
    return add(std::move(curve->smooth), z_mm, options.le_hint, options.te_hint);
}

core::Status SurfaceCompensation::add(SmoothCurve centres, double z_mm, const std::optional<Vec2>& le_hint,
                                      const std::optional<Vec2>& te_hint) {
    const bool first = own_.empty();
    auto row = SurfaceRow::make(std::move(centres), z_mm, ball_radius_, first ? le_hint : own_.back().le(),
                                first ? te_hint : own_.back().te());
    if (!row) return tl::unexpected(row.error());
    own_.push_back(std::move(*row));
    if (auto status = check_rows(own_); !status) {
        own_.pop_back();
        return status;
    }
    fit_.reset();
    if (newest_ > 0 && own_.size() > newest_) own_.erase(own_.begin());
    return {};
}

core::Status SurfaceCompensation::fit() {
    rows_ = settle_rows(own_, newest_ > 0 ? growing_rounds : rounds_for(own_.size()));
    SurfaceFitOptions options;
    options.beyond_mm = ball_radius_;
    auto fit = fit_surface(rows_, options);
    if (!fit) return tl::unexpected(fit.error());
    fit_ = std::move(*fit);
    return {};
}

core::Result<ContactContour> SurfaceCompensation::contour(double z_mm, std::size_t count) const {
    if (!fit_) return core::fail(ErrorCode::fit_not_evaluable, "compensation: there is no surface of ball centres");
    if (!(z_mm >= rows_.front().z_mm() && z_mm <= rows_.back().z_mm()))
        return core::fail(ErrorCode::fit_not_evaluable, "compensation: the height lies beyond the sections");
    const Surface& surface = fit_->surface;
    const auto coarse = touched_cut(surface, -ball_radius_, z_mm, span_parameters(surface.u(), 3));
    if (!coarse) return tl::unexpected(coarse.error());
    if (coarse->points.size() < 8)
        return core::fail(ErrorCode::fit_not_evaluable, "compensation: the ball is larger than what it touched");
    const double period = surface.u().back() - surface.u().front();
    auto fine = touched_cut(surface, -ball_radius_, z_mm, spread(*coarse, period, std::max(count, fewest_points)));
    if (!fine) return tl::unexpected(fine.error());
    ContactContour contour;
    contour.z_mm = z_mm;
    contour.final = z_mm < rows_.back().z_mm();
    contour.unreached = fine->folded;
    for (const CutPoint& p : fine->points)
        contour.points.push_back({p.position, p.normal, std::asin(std::clamp(p.normal.z(), -1.0, 1.0))});
    return contour;
}

}  // namespace cmm::fitting
