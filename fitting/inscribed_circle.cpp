// SPDX-License-Identifier: Apache-2.0
#include "fitting/inscribed_circle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmm::fitting {
namespace {

constexpr int most_steps = 60;
constexpr int steps_beside = 6;
constexpr double equal_mm = 1e-8;  // a hundredth of a nanometre
constexpr double resting_mm = 1e-10;
constexpr double least_slope = 0.2;  // of the difference of the distances, which is 2 between parallel sides
constexpr double most_alike = 0.7;   // cosine between the directions to both sides

}  // namespace

SectionSides SectionSides::of(const SectionFit& fit, const ContourGeometry& contour) {
    SectionSides sides;
    const std::size_t n = contour.size();
    sides.le = contour.nearest_point(fit.le_point_mm);
    sides.te = contour.nearest_point(fit.te_point_mm);
    const std::size_t ahead = (sides.te + n - sides.le) % n;
    const ContourRange after_le{sides.le, ahead + 1}, after_te{sides.te, n - ahead + 1};
    std::size_t suction = 0, pressure = 0;
    for (std::size_t k = 0; k < ahead; ++k) {
        const Zone zone = contour.point(sides.le + k).zone;
        suction += zone == Zone::suction;
        pressure += zone == Zone::pressure;
    }
    sides.suction = suction >= pressure ? after_le : after_te;
    sides.pressure = suction >= pressure ? after_te : after_le;
    return sides;
}

Vec2 InscribedCircle::along(const Vec2& forward) const {
    const Vec2 halving = left_of(to_suction - to_pressure).normalized();
    return halving.dot(forward) < 0.0 ? Vec2(-halving) : halving;
}

void InscribedCircle::add_shift(const ContourGeometry& contour, const Vec2& across, double weight,
                                Sensitivity& number) const {
    const double share = weight / across.dot(to_suction - to_pressure);
    contour.add(on_suction, share, number);
    contour.add(on_pressure, -share, number);
}

void InscribedCircle::add_radius(const ContourGeometry& contour, const Vec2& across, double weight,
                                 Sensitivity& number) const {
    contour.add(on_suction, weight, number);
    add_shift(contour, across, -weight * across.dot(to_suction), number);
}

std::optional<InscribedCircle> InscribedCircleFinder::on_line(const Vec2& start, const Vec2& across) const {
    double x = 0.0, low = -std::numeric_limits<double>::infinity(), high = -low;
    InscribedCircle circle;
    for (int step = 0; step < most_steps; ++step) {
        circle.centre = start + x * across;
        // The whole sides at first and from time to time, in between what is next to the last places.
        const bool whole = step % steps_beside == 0;
        circle.on_suction = contour_->foot(circle.centre, sides_.suction, whole ? nullptr : &circle.on_suction);
        circle.on_pressure = contour_->foot(circle.centre, sides_.pressure, whole ? nullptr : &circle.on_pressure);
        const Vec2 to_suction = contour_->position(circle.on_suction) - circle.centre;
        const Vec2 to_pressure = contour_->position(circle.on_pressure) - circle.centre;
        const double suction = to_suction.norm(), pressure = to_pressure.norm();
        if (!(suction > equal_mm && pressure > equal_mm)) return {};
        circle.radius = 0.5 * (suction + pressure);
        circle.to_suction = to_suction / suction;
        circle.to_pressure = to_pressure / pressure;
        const double off = suction - pressure;
        (off > 0.0 ? low : high) = x;
        const double slope = across.dot(circle.to_pressure - circle.to_suction);
        double next = x + (slope < -least_slope ? -off / slope : 0.5 * off);
        if (std::isfinite(low) && std::isfinite(high) && !(next > low && next < high)) next = 0.5 * (low + high);
        if (std::abs(off) <= equal_mm || std::abs(next - x) <= resting_mm) {
            if (circle.to_suction.dot(circle.to_pressure) > most_alike) return {};
            return circle;
        }
        x = next;
    }
    return {};
}

}  // namespace cmm::fitting
