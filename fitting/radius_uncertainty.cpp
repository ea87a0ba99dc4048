// SPDX-License-Identifier: Apache-2.0
#include "fitting/radius_uncertainty.hpp"

#include <Eigen/Cholesky>
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

/// By another height of the section the whole zone changes; the circle through it follows better than a model whose
/// ends and halves are its own.
double plane_variance(const SectionFit& fit, Zone zone) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    const auto row = [](const ContourPoint& p) { return Eigen::Vector3d(p.normal.x(), p.normal.y(), 1.0); };
    for (const auto& point : fit.contour)
        if (point.zone == zone) normal += row(point) * row(point).transpose();
    const Eigen::Vector3d radius = normal.ldlt().solve(Eigen::Vector3d::UnitZ());
    Sensitivity slopes;
    for (std::size_t i = 0; i < fit.contour.size(); ++i)
        if (fit.contour[i].zone == zone) slopes.add(i, row(fit.contour[i]).dot(radius));
    return fit.contour_noise.plane_variance(slopes);
}

}  // namespace

NumberUncertainty radius_uncertainty(const SectionFit& fit, Zone zone) {
    const EdgeFit& edge = zone == Zone::le ? fit.le : fit.te;
    const double coverage = fit.contour_noise.coverage(), by_plane = plane_variance(fit, zone);
    Sensitivity slopes;
    slopes.add(edge.slopes[2], moved_window);
    const double variance = std::pow(edge.radius_u95_mm / coverage, 2) + by_plane;
    NumberUncertainty out = fit.contour_noise.of(fit.contour, {}, {variance, slopes});
    if (!fit.contour_noise.has_fields()) {
        // or to the last bit as it was
        out.u95 = std::hypot(edge.radius_u95_mm, coverage * std::sqrt(by_plane)) + out.budget.bound;
        return out;
    }
    const double bound = difference_to_arc(fit, edge);
    out.budget.bound += bound;
    out.u95 += bound;
    out.standard = out.u95 / coverage;
    return out;
}

}  // namespace cmm::fitting
