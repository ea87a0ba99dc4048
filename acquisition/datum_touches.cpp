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

std::string opposite_name(std::size_t index) {
    return "the opposite touch of " + datum_name(index);
}

/// The foot on the nominal and its normal in space.
core::Result<fitting::DatumTouch> foot_on(const Nominal& nominal, const Vector3d& at, const std::string& name) {
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
    return fitting::DatumTouch{{at_foot.position.x(), at_foot.position.y(), at.z()},
                               {in_plane.x(), in_plane.y(), std::sin(lean)}};
}

core::Result<fitting::DatumTouch> touch_at(const Nominal& nominal, const DatumPlace& place, const std::string& name) {
    if (place.normal) return fitting::DatumTouch{place.at_mm, *place.normal};
    return foot_on(nominal, place.at_mm, name);
}

}  // namespace

core::Result<fitting::SixPoints> on_nominal(const SixPointSpec& spec, const Nominal& nominal) {
    fitting::SixPoints points;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto touch = touch_at(nominal, spec.places[i], datum_name(i));
        if (!touch) return tl::unexpected(touch.error());
        points[i] = {touch->place_mm, touch->normal};
        if (!spec.places[i].opposite) continue;
        const auto opposite = touch_at(nominal, *spec.places[i].opposite, opposite_name(i));
        if (!opposite) return tl::unexpected(opposite.error());
        points[i].opposite = *opposite;
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
    for (const auto& touch : fitting::touches_of(points))
        touches.push_back({touch.place_mm + ball_radius_mm * touch.normal, touch.normal, speed_mm_s, true});
    return touches;
}

DatumMiddles middles_of(const fitting::SixPoints& points) {
    DatumMiddles middles{};
    for (std::size_t i = 0; i < points.size(); ++i)
        middles[i] = points[i].opposite.has_value();
    return middles;
}

fitting::SixPoints points_touched(std::span<const drivers::PathPoint> touches, const DatumMiddles& middles,
                                  double ball_radius_mm) {
    std::size_t next = 0;
    const auto take = [&]() -> fitting::DatumTouch {
        const auto& touch = touches[next++];
        return {touch.centre_mm - ball_radius_mm * touch.normal, touch.normal};
    };
    fitting::SixPoints points;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto touch = take();
        points[i] = {touch.place_mm, touch.normal};
        if (middles[i]) points[i].opposite = take();
    }
    return points;
}

std::string datum_touch_name(const DatumMiddles& middles, std::size_t touch) {
    for (std::size_t i = 0; i < middles.size(); ++i) {
        if (touch == 0) return datum_name(i);
        if (middles[i] && touch == 1) return opposite_name(i);
        touch -= middles[i] ? 2 : 1;
    }
    return {};
}

}  // namespace cmm::acquisition
