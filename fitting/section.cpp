// SPDX-License-Identifier: Apache-2.0
#include "fitting/section.hpp"

#include <cmath>
#include <utility>

#include "fitting/centre_curve.hpp"
#include "fitting/contour.hpp"

namespace cmm::fitting {

core::Result<SectionFit> fit_section(std::span<const Eigen::Vector2d> centres, std::span<const RejectReason> excluded,
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
    fit.noise_sigma_mm = centre_curve->smooth.sigma_mm;
    if (auto status = build_contour(centre_curve->smooth, centre_curve->good, options, fit); !status)
        return tl::unexpected(status.error());
    fit.centres = {std::move(centre_curve->smooth), std::move(centre_curve->good)};
    return fit;
}

}  // namespace cmm::fitting
