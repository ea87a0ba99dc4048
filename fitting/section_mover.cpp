// SPDX-License-Identifier: Apache-2.0
#include "fitting/section_mover.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/open_edges.hpp"

namespace cmm::fitting {
namespace {

constexpr double still_radii = 1.0, faded_radii = 2.0;  // from a place that stays

/// In the lean: whole where it is known better than the 2-D offset errs, or than the noise tells; none from twice that
/// on.
double trust(const SurfaceStation& s, const SmoothCurve& smooth) {
    const double noise = 2.0 * smooth.noise.sigma_mm(s.t);
    return std::clamp(2.0 - s.lean_doubt_mm / std::max(s.offset_error_mm, noise), 0.0, 1.0);
}

/// What stays as it is, and its surroundings; what is moved by a part.
void fade(const SmoothCurve& smooth, const SectionFit& flat, double r, SectionMovement& movement) {
    std::vector<Vec2> still;
    for (const ContourPoint& point : flat.contour)
        if (!point.reached) still.emplace_back(point.position_mm + r * point.normal);
    for (std::size_t k = 0; k < movement.shift.size(); ++k) {
        const Vec2& own = smooth.curve.pieces()[k][0];
        SurfaceStation& s = movement.stations[k];
        double nearest = faded_radii * r;
        for (const Vec2& p : still)
            nearest = std::min(nearest, (p - own).norm());
        const double x = std::clamp((nearest / r - still_radii) / (faded_radii - still_radii), 0.0, 1.0);
        const double share = x * x * (3.0 - 2.0 * x) * (s.moved ? trust(s, smooth) : 1.0);
        movement.shift[k] *= share;
        if (!s.moved || share == 1.0) continue;
        s.moved = false;
        s.offset_error_mm *= 1.0 - share;
        s.offset_error_mm += std::exchange(s.lean_doubt_mm, 0.0);
        s.drawn_doubt_mm = 0.0;
        s.noise_share = 1.0 + share * (s.noise_share - 1.0);
        s.scatter_share = 1.0 + share * (s.scatter_share - 1.0);
        s.kept_share = 1.0 + share * (s.kept_share - 1.0);
    }
}

}  // namespace

core::Result<SurfaceSection> move_section(const SmoothCurve& smooth, SectionMovement movement, const SectionFit& flat,
                                          const SectionOptions& options) {
    fade(smooth, flat, options.ball_radius_mm, movement);
    const PiecewiseCubic shift = interpolate_periodic(movement.shift, smooth.curve.breaks());
    std::vector<PiecewiseCubic::Piece> pieces = smooth.curve.pieces();
    for (std::size_t k = 0; k < pieces.size(); ++k)
        for (std::size_t j = 0; j < 4; ++j)
            pieces[k][j] += shift.pieces()[k][j];
    SmoothCurve moved = smooth;
    moved.curve = PiecewiseCubic(smooth.curve.breaks(), std::move(pieces), true);
    std::vector<Vec2> points = flat.centres.points;
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] += shift.jet(moved.parameter[i]).position;

    SurfaceSection result;
    result.fit.missing = flat.missing;
    result.fit.verdicts = flat.verdicts;
    result.fit.rejected = flat.rejected;
    result.fit.noise_sigma_mm = flat.noise_sigma_mm;
    SectionOptions own = options;
    own.le_hint = flat.le_point_mm;
    own.te_hint = flat.te_point_mm;
    own.lean_rad = 0.0;
    const auto open = build_contour(moved, points, own, result.fit, movement.stations);
    if (!open) return tl::unexpected(open.error());
    fit_open_edges(*open, moved, points, result.fit);
    result.fit.centres = flat.centres;
    std::size_t count = 0;
    for (const SurfaceStation& s : movement.stations) {
        if (!s.moved) continue;
        ++count;
        result.lean_doubt_mm = std::max(result.lean_doubt_mm, s.lean_doubt_mm);
        result.offset_error_mm = std::max(result.offset_error_mm, s.offset_error_mm);
    }
    result.share = static_cast<double>(count) / static_cast<double>(movement.stations.size());
    return result;
}

}  // namespace cmm::fitting
