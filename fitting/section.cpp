// SPDX-License-Identifier: Apache-2.0
#include "fitting/section.hpp"

#include <cmath>
#include <memory>
#include <utility>

#include "fitting/centre_curve.hpp"
#include "fitting/contour.hpp"
#include "fitting/open_edges.hpp"

namespace cmm::fitting {

core::Result<SectionFit> fit_contour(std::span<const Eigen::Vector2d> centres, std::span<const RejectReason> excluded,
                                     const SectionOptions& options, std::span<const char> kept,
                                     std::span<const char> later) {
    if (!std::isfinite(options.ball_radius_mm) || options.ball_radius_mm < 0.0)
        return core::fail(core::ErrorCode::fit_not_evaluable, "section: the ball radius must be a number, 0 or more");
    auto centre_curve = fit_centre_curve(centres, excluded, options, kept, later);
    if (!centre_curve) return tl::unexpected(centre_curve.error());
    SectionFit fit;
    fit.missing = std::move(centre_curve->missing);
    fit.verdicts = std::move(centre_curve->verdicts);
    fit.rejected = centre_curve->rejected;
    fit.noise_sigma_mm = centre_curve->of_contour().sigma_mm;
    auto open = build_contour(centre_curve->of_contour(), centre_curve->good, options, fit);
    if (!open) return tl::unexpected(open.error());
    open->curve = std::move(centre_curve->with_edges);
    fit.centres = {std::move(centre_curve->smooth), std::move(centre_curve->good)};
    fit.open_edges = std::make_shared<const OpenEdges>(std::move(*open));
    return fit;
}

void fit_edges(SectionFit& fit) {
    const auto open = std::exchange(fit.open_edges, nullptr);
    if (!open) return;
    fit_open_edges(*open, open->curve ? *open->curve : fit.centres.curve, fit.centres.points, fit);
}

core::Result<SectionFit> fit_section(std::span<const Eigen::Vector2d> centres, std::span<const RejectReason> excluded,
                                     const SectionOptions& options, std::span<const char> kept,
                                     std::span<const char> later) {
    auto fit = fit_contour(centres, excluded, options, kept, later);
    if (fit) fit_edges(*fit);
    return fit;
}

}  // namespace cmm::fitting
