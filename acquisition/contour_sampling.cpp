// SPDX-License-Identifier: Apache-2.0
#include "acquisition/contour_sampling.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "fitting/vec2.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using fitting::cross;

constexpr double chord_error_mm = 2e-4;
constexpr double fewest_samples = 1200.0;
constexpr double densest = 40.0;  // at most so many times denser than the even spacing: bounds what a kink may ask for

}  // namespace

std::vector<double> dense_parameters(const std::function<Vector2d(double)>& position, const std::vector<double>& coarse,
                                     double period) {
    const std::size_t n = coarse.size();
    std::vector<Vector2d> points(n);
    std::transform(coarse.begin(), coarse.end(), points.begin(), position);
    std::vector<Vector2d> step(n);
    double length = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        step[i] = points[(i + 1) % n] - points[i];
        length += step[i].norm();
    }
    const double widest = length / fewest_samples;
    // Points wanted up to each coarse parameter: arc length over the local step sqrt(8 e / kappa).
    std::vector<double> wanted(n + 1, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
        const Vector2d &before = step[(i + n - 1) % n], &here = step[i], &after = step[(i + 1) % n];
        const double turn = std::abs(std::atan2(cross(before, here), before.dot(here))) +
                            std::abs(std::atan2(cross(here, after), here.dot(after)));
        const double reach = here.norm() + 0.5 * (before.norm() + after.norm());
        const double kappa = reach > 0.0 ? turn / reach : 0.0;
        const double fine = kappa > 0.0 ? std::sqrt(8.0 * chord_error_mm / kappa) : widest;
        wanted[i + 1] = wanted[i] + here.norm() / std::clamp(fine, widest / densest, widest);
    }
    const auto count = static_cast<std::size_t>(std::ceil(wanted.back()));
    std::vector<double> parameters(count);
    std::size_t span = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double target = wanted.back() * static_cast<double>(k) / static_cast<double>(count);
        while (wanted[span + 1] < target)
            ++span;
        const double from = coarse[span], to = span + 1 < n ? coarse[span + 1] : coarse[0] + period;
        parameters[k] = from + (to - from) * (target - wanted[span]) / (wanted[span + 1] - wanted[span]);
    }
    return parameters;
}

double signed_area(const std::vector<Vector2d>& polygon) noexcept {
    double doubled = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        // Relative to the first point: far from the origin the terms would cancel badly.
        const Vector2d a = polygon[i] - polygon[0], b = polygon[(i + 1) % polygon.size()] - polygon[0];
        doubled += cross(a, b);
    }
    return 0.5 * doubled;
}

NominalContour contour_from(double z_mm, const std::vector<CutPoint>& cut) {
    NominalContour contour;
    contour.z_mm = z_mm;
    contour.points.reserve(cut.size());
    const std::size_t n = cut.size();
    for (std::size_t i = 0; i < n; ++i) {
        contour.points.push_back(cut[i].position_mm);
        const Vector2d along = cut[(i + 1) % n].position_mm - cut[(i + n - 1) % n].position_mm;
        const Eigen::Vector3d normal = Eigen::Vector3d(along.x(), along.y(), 0.0).cross(cut[i].spanwise);
        const double size = normal.norm();
        contour.leans_rad.push_back(size > 0.0 ? std::asin(std::clamp(normal.z() / size, -1.0, 1.0)) : 0.0);
        contour.lean_rad = std::max(contour.lean_rad, std::abs(contour.leans_rad.back()));
    }
    if (signed_area(contour.points) < 0.0) {
        std::reverse(contour.points.begin(), contour.points.end());
        std::reverse(contour.leans_rad.begin(), contour.leans_rad.end());
        for (double& lean : contour.leans_rad)
            lean = -lean;  // the normals pointed inwards
    }
    return contour;
}

}  // namespace cmm::acquisition
