// SPDX-License-Identifier: Apache-2.0
#include "fitting/radius_uncertainty.hpp"

#include <cmath>

namespace cmm::fitting {
namespace {

// The points that belong to the edge are chosen by themselves: lobes of the probe move where it ends, and first order
// does not know that. Measured on the three families: the variance is 1.2 times as large.
const double moved_window = std::sqrt(1.2);
constexpr double sure_of_probe = 2.0;  // standard uncertainties of a point: more the probe does not make of an arc

/// How far the arc's radius is from the one that was chosen, where the arc is not out of the question.
double difference_to_arc(const SectionFit& fit, const EdgeFit& edge) {
    if (edge.model == EdgeModel::arc) return 0.0;
    const double allowed_mm = std::hypot(fit.noise_sigma_mm, sure_of_probe * fit.contour_noise.direction_mm());
    double difference = 0.0;
    for (const EdgeEvidence& tried : edge.evidence)
        if (tried.arc_radius_mm > 0.0 && tried.rms_mm <= allowed_mm)
            difference = std::abs(tried.arc_radius_mm - edge.radius_mm);
    return difference;
}

}  // namespace

NumberUncertainty radius_uncertainty(const SectionFit& fit, const EdgeFit& edge) {
    const double standard = edge.radius_u95_mm / fit.contour_noise.coverage();
    Sensitivity slopes;
    slopes.add(edge.slopes[2], moved_window);
    NumberUncertainty out = fit.contour_noise.of(fit.contour, {}, {standard * standard, slopes});
    if (!fit.contour_noise.has_fields()) {
        const double by_plane = fit.contour_noise.coverage() * std::sqrt(fit.contour_noise.plane_variance(slopes));
        out.u95 = std::hypot(edge.radius_u95_mm, by_plane);  // without a plane error to the last bit
        return out;
    }
    const double bound = difference_to_arc(fit, edge);
    out.budget.bound += bound;
    out.u95 += bound;
    out.standard = out.u95 / fit.contour_noise.coverage();
    return out;
}

}  // namespace cmm::fitting
