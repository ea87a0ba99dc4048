// SPDX-License-Identifier: Apache-2.0
#include "acquisition/datum_touches.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/text.hpp"
#include "fitting/closed_curve.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// More than rounding in a drawing, less than what a wrong height or side makes.
constexpr double off_nominal_mm = 0.05;
constexpr double upright_rad = 1e-6;

std::string datum_name(std::size_t index) {
    return "datum point " + std::to_string(index + 1);
}

/// The foot on the nominal and its normal in space.
core::Result<fitting::DatumPoint> foot_on(const Nominal& nominal, const Vector3d& at, const std::string& name) {
    const std::string give = "; give it a direction of its own";
    const auto cut = nominal.cut(at.z());
    if (!cut)
        return core::fail(core::ErrorCode::config_invalid,
                          "alignment: " + name + " is not on the nominal: " + cut.error().message + give);
    const auto curve = fitting::ClosedCurve::through(cut->points);
    if (!curve) return tl::unexpected(curve.error());
    const auto foot = curve->closest(at.head<2>());
    if (std::abs(foot.distance_mm) > off_nominal_mm) {
        return core::fail(core::ErrorCode::config_invalid, "alignment: " + name + " lies " +
                                                               core::length_text(std::abs(foot.distance_mm)) +
                                                               " beside the nominal" + give);
    }
    if (cut->leans_rad.empty() && cut->lean_rad > upright_rad) {
        return core::fail(core::ErrorCode::config_invalid,
                          "alignment: the nominal does not know the lean of its surface at " + name + give);
    }
    double lean = 0.0, nearest = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < cut->leans_rad.size(); ++i) {
        const double distance = (cut->points[i] - at.head<2>()).squaredNorm();
        if (distance >= nearest) continue;
        nearest = distance;
        lean = cut->leans_rad[i];
    }
    const auto at_foot = curve->evaluate(foot.s_mm);
    const Vector2d in_plane = std::cos(lean) * at_foot.normal;
    return fitting::DatumPoint{{at_foot.position.x(), at_foot.position.y(), at.z()},
                               {in_plane.x(), in_plane.y(), std::sin(lean)}};
}

}  // namespace

core::Result<fitting::SixPoints> on_nominal(const SixPointSpec& spec, const Nominal& nominal) {
    fitting::SixPoints points;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& place = spec.places[i];
        if (place.normal) {
            points[i] = {place.at_mm, *place.normal};
            continue;
        }
        auto foot = foot_on(nominal, place.at_mm, datum_name(i));
        if (!foot) return tl::unexpected(std::move(foot.error()));
        points[i] = *foot;
    }
    if (auto held = fitting::require_hold(points, spec.largest_condition); !held) {
        held.error().message = "alignment: " + held.error().message;
        return tl::unexpected(std::move(held.error()));
    }
    return points;
}

std::vector<drivers::PathPoint> datum_touches(const fitting::SixPoints& points, double ball_radius_mm,
                                              double speed_mm_s) {
    std::vector<drivers::PathPoint> touches;
    for (const auto& point : points)
        touches.push_back({point.place_mm + ball_radius_mm * point.normal, point.normal, speed_mm_s, true});
    return touches;
}

fitting::SixPoints points_touched(std::span<const drivers::PathPoint> touches, double ball_radius_mm) {
    fitting::SixPoints points;
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] = {touches[i].centre_mm - ball_radius_mm * touches[i].normal, touches[i].normal};
    return points;
}

}  // namespace cmm::acquisition
