// SPDX-License-Identifier: Apache-2.0
#include "fitting/camber_line.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "fitting/camber_line_builder.hpp"

namespace cmm::fitting {
namespace {

/// Where nose and tail are sought is told by the same points as what is found there: what that adds to their standard
/// deviation, measured on the three families (docs/measured.md). Of all that moves them alike, or a number of a contour
/// that is moved as a whole would feel it.
constexpr double chosen_place = 1.12;

constexpr int search_steps = 40;
constexpr double still_mm = 1e-9;

core::Result<CamberPlace> no_camber(const char* why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, why);
}

}  // namespace

double CamberEnd::Arc::ordinate(double x) const {
    if (!(radius > 0.0)) return 0.0;
    const double along = x - centre.x();
    return centre.y() + side * std::sqrt(std::max(0.0, radius * radius - along * along));
}

double CamberEnd::Arc::slope(double x) const {
    if (!(radius > 0.0)) return 0.0;
    const double along = std::clamp(x - centre.x(), -0.999 * radius, 0.999 * radius);
    return -side * along / std::sqrt(radius * radius - along * along);
}

Eigen::RowVector4d CamberEnd::powers(double x) const {
    const double w = x / unit_mm_;
    return {1.0, w, w * w, w * w * w};
}

Eigen::RowVector4d CamberEnd::slopes(double x) const {
    const double w = x / unit_mm_;
    return {0.0, 1.0 / unit_mm_, 2.0 * w / unit_mm_, 3.0 * w * w / unit_mm_};
}

void CamberEnd::add_cubic(const ContourGeometry& contour, double x, double weight, Sensitivity& number) const {
    const Eigen::RowVectorXd weights = powers(x) * fit_;
    for (std::size_t k = 0; k < circles_.size(); ++k)
        circles_[k].add_shift(contour, across_,
                              weight * weights[static_cast<Eigen::Index>(k)] * across_.dot(left_of(axis_)), number);
}

void CamberEnd::add(const ContourGeometry& contour, const Vec2& gradient, Sensitivity& number) const {
    contour.add(place_, chosen_place * gradient.dot(by_normal_), number);
    add_cubic(contour, x_, chosen_place * gradient.dot(by_camber_), number);
}

core::Result<CamberLine> CamberLine::of(const SectionFit& fit, const ContourGeometry& contour) {
    CamberLine line(contour, SectionSides::of(fit, contour));
    if (auto status = CamberLineBuilder(fit, line).run(); !status) return tl::unexpected(status.error());
    return line;
}

/// From the pressure to the suction side.
Vec2 CamberLine::across(const Vec2& forward, const InscribedCircle& near) const {
    const Vec2 left = left_of(forward);
    return left.dot(near.to_suction - near.to_pressure) < 0.0 ? Vec2(-left) : left;
}

std::optional<InscribedCircle> CamberLine::between(std::size_t k, double share) const {
    const InscribedCircle &a = circles_[k], &b = circles_[k + 1];
    const Vec2 forward = (b.centre - a.centre).normalized();
    return finder_.on_line(a.centre + share * (b.centre - a.centre), across(forward, a));
}

double CamberLine::arc_at(std::size_t k, const Vec2& centre) const {
    return arc_mm_[k] + (centre - circles_[k].centre).norm();
}

CamberLine::Thickest CamberLine::thickest() const {
    const auto smaller = [](const InscribedCircle& a, const InscribedCircle& b) { return a.radius < b.radius; };
    const auto largest =
        static_cast<std::size_t>(std::max_element(circles_.begin(), circles_.end(), smaller) - circles_.begin());
    Thickest out;
    const std::size_t n = circles_.size();
    const auto finish = [&](const InscribedCircle& circle, std::size_t k) {
        out.circle = circle;
        out.arc_mm = arc_at(k, circle.centre);
        const std::size_t before = std::clamp<std::size_t>(k, 1, n - 3) - 1, after = before + 3;
        const Vec2 forward = circles_[after].centre - circles_[before].centre;
        out.along = circle.along(forward);
        out.bend =
            (circles_[after].growth(forward) - circles_[before].growth(forward)) / (arc_mm_[after] - arc_mm_[before]);
        return out;
    };
    // Between the neighbours the growth falls through zero.
    for (std::size_t k = largest > 0 ? largest - 1 : 0; k < largest + 1 && k + 1 < n; ++k) {
        const Vec2 forward = circles_[k + 1].centre - circles_[k].centre;
        double low = 0.0, high = 1.0;
        double at_low = circles_[k].growth(forward), at_high = circles_[k + 1].growth(forward);
        if (at_low < 0.0 || at_high > 0.0) continue;
        std::optional<InscribedCircle> found = circles_[at_low > -at_high ? k + 1 : k];
        for (int step = 0; step < search_steps && (high - low) * forward.norm() > still_mm; ++step) {
            // Half way from time to time: the false position alone may creep.
            const double share = step % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * at_low / (at_low - at_high);
            const auto circle = between(k, share);
            if (!circle) break;
            found = circle;
            const double growth = circle->growth(forward);
            if (growth == 0.0) break;
            (growth > 0.0 ? low : high) = share;
            (growth > 0.0 ? at_low : at_high) = growth;
        }
        return finish(*found, k);
    }
    return finish(circles_[largest], std::min(largest, n - 2));
}

core::Result<CamberPlace> CamberLine::at_distance(const CamberEnd& end, double distance_mm) const {
    const bool from_le = &end == &le_;
    CamberPlace out;
    const auto distance = [&](const Vec2& p) { return (p - end.point_).norm(); };
    const std::size_t n = circles_.size();
    const auto counted = [&](std::size_t k) { return from_le ? k : n - 1 - k; };
    // Up to the first circle, which stands half a radius behind the place where circles may begin at most, and beside
    // the cubic.
    const InscribedCircle& first = circles_[counted(0)];
    if (distance(first.centre) >= distance_mm || distance(end.on_cubic(end.first_mm_)) >= distance_mm) {
        double low = end.x_;
        double high = std::max(end.first_mm_, (first.centre - end.origin_).dot(end.axis_)) + first.radius;
        for (int step = 0; step < search_steps; ++step) {
            const double middle = 0.5 * (low + high);
            (distance(end.on_cubic(middle)) < distance_mm ? low : high) = middle;
        }
        out.position = end.on_cubic(low);
        out.inward = end.direction(low);
        end.add_cubic(*contour_, low, left_of(out.inward).dot(left_of(end.axis_)), out.across);
        return out;
    }
    std::size_t k = 0;
    while (k < n && distance(circles_[counted(k)].centre) < distance_mm)
        ++k;
    if (k == n) return no_camber("the camber line does not reach so far");
    const InscribedCircle &near = circles_[counted(k - 1)], &far = circles_[counted(k)];
    const Vec2 step = far.centre - near.centre, forward = step.normalized(), side = across(forward, near);
    double share = 0.5;
    std::optional<InscribedCircle> circle;
    for (int round = 0; round < search_steps; ++round) {
        circle = finder_.on_line(near.centre + share * step, side);
        if (!circle) return no_camber("no circle fits between the sides there");
        const double missing = distance_mm - distance(circle->centre);
        if (std::abs(missing) < still_mm) break;
        share += missing / step.norm();
    }
    out.position = circle->centre;
    out.inward = circle->along(forward);
    const Vec2 left = left_of(out.inward);
    circle->add_shift(*contour_, side, 1.0 / side.dot(left), out.across);
    return out;
}

}  // namespace cmm::fitting
