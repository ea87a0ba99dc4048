// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "acquisition/reference_contour.hpp"
#include "acquisition/section_result.hpp"
#include "core/rng.hpp"
#include "core/units.hpp"
#include "fitting/section.hpp"

/// Fits and recorded points with a known truth, made from the formulas of docs/part-file.md without any fitting.
namespace cmm::acquisition::synthetic {

using Eigen::Vector2d;
using fitting::ContourPoint;
using fitting::Zone;

struct Shape {
    double chord_mm = 60.0, thickness_mm = 6.0, camber_rad = core::rad_from_deg(28.0),
           stagger_rad = core::rad_from_deg(30.0);
    double le_radius_mm = 0.4, te_radius_mm = 0.25;
};

/// The blade section by its camber line and inscribed circles; counter-clockwise, from the LE nose over the pressure
/// side.
class Section {
  public:
    explicit Section(const Shape& shape) : shape_(shape) {
        base_ = shape.chord_mm - shape.le_radius_mm - shape.te_radius_mm;
        arc_ = base_ / (2.0 * std::sin(shape.camber_rad / 2.0)) * shape.camber_rad;
    }

    std::vector<ContourPoint> contour(std::size_t per_side = 900, std::size_t per_edge = 300) const {
        std::vector<ContourPoint> points;
        const double le_top = direction(0.0, +1.0);
        const double te_top = direction(1.0, +1.0);
        const double nose = heading(0.0) + std::numbers::pi;
        const double tail = heading(1.0);
        const double le_bottom = direction(0.0, -1.0) + 2.0 * std::numbers::pi;
        add_arc(points, 0.0, nose, le_bottom, per_edge / 2, Zone::le);
        add_side(points, -1.0, per_side, Zone::pressure);
        add_arc(points, 1.0, direction(1.0, -1.0), tail, per_edge / 2, Zone::te);
        add_arc(points, 1.0, tail, te_top, per_edge / 2, Zone::te);
        add_side(points, +1.0, per_side, Zone::suction);
        add_arc(points, 0.0, le_top, nose, per_edge / 2, Zone::le);
        for (std::size_t i = 1; i < points.size(); ++i) {
            points[i].arc_length_mm =
                points[i - 1].arc_length_mm + (points[i].position_mm - points[i - 1].position_mm).norm();
        }
        return points;
    }
    Vector2d nose() const { return on_edge(0.0, heading(0.0) + std::numbers::pi).position_mm; }
    Vector2d tail() const { return on_edge(1.0, heading(1.0)).position_mm; }
    Vector2d edge_centre(double t) const { return turned(camber(t)); }

  private:
    double heading(double t) const { return shape_.stagger_rad - (t - 0.5) * shape_.camber_rad; }
    Vector2d camber(double t) const {
        const double a = (t - 0.5) * shape_.camber_rad;
        const double radius = arc_ / shape_.camber_rad;
        return {radius * std::sin(a), radius * (std::cos(a) - std::cos(shape_.camber_rad / 2.0))};
    }
    double bulge() const { return shape_.thickness_mm / 2.0 - (shape_.le_radius_mm + shape_.te_radius_mm) / 2.0; }
    double rho(double t) const {
        return shape_.le_radius_mm * (1.0 - t) + shape_.te_radius_mm * t +
               bulge() * (2.0 * t * (1.0 - t) + 3.375 * t * (1.0 - t) * (1.0 - t));
    }
    double slope(double t) const {
        return (shape_.te_radius_mm - shape_.le_radius_mm +
                bulge() * (2.0 - 4.0 * t + 3.375 * (1.0 - t) * (1.0 - 3.0 * t))) /
               arc_;
    }
    /// Angle of the outward normal of a side at t: -q e +- sqrt(1 - q^2) n.
    double direction(double t, double side) const {
        const double q = slope(t);
        return heading(t) + std::atan2(side * std::sqrt(1.0 - q * q), -q);
    }
    Vector2d turned(const Vector2d& p) const {
        const double c = std::cos(shape_.stagger_rad);
        const double s = std::sin(shape_.stagger_rad);
        return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
    }
    ContourPoint on_edge(double t, double angle) const {
        ContourPoint point;
        point.normal = {std::cos(angle), std::sin(angle)};
        point.position_mm = turned(camber(t)) + rho(t) * point.normal;
        return point;
    }
    void add_arc(std::vector<ContourPoint>& points, double t, double from, double to, std::size_t count,
                 Zone zone) const {
        for (std::size_t i = 0; i < count; ++i) {
            points.push_back(on_edge(t, from + (to - from) * static_cast<double>(i) / static_cast<double>(count)));
            points.back().zone = zone;
        }
    }
    void add_side(std::vector<ContourPoint>& points, double side, std::size_t count, Zone zone) const {
        for (std::size_t i = 0; i < count; ++i) {
            const double along = static_cast<double>(i) / static_cast<double>(count);
            const double t = side < 0.0 ? along : 1.0 - along;
            points.push_back(on_edge(t, direction(t, side)));
            points.back().zone = zone;
        }
    }

    Shape shape_;
    double base_ = 0.0;
    double arc_ = 0.0;
};

inline std::vector<Vector2d> positions(const std::vector<ContourPoint>& contour) {
    std::vector<Vector2d> points;
    for (const auto& point : contour)
        points.push_back(point.position_mm);
    return points;
}

/// The section as a nominal for a ball of that radius; it stands upright.
inline ReferenceContour reference(const Section& section, double ball_radius_mm) {
    const NominalContour contour{0.0, positions(section.contour()), 0.0, {}};
    return {contour, fitting::ClosedCurve::through(contour.points).value(), ball_radius_mm};
}

/// How the circle of least squares through an edge answers to its points.
inline void answer_by_circle(const std::vector<fitting::ContourPoint>& contour, Zone zone, fitting::EdgeFit& edge) {
    const auto row = [](const auto& point) { return Eigen::Vector3d(point.normal.x(), point.normal.y(), 1.0); };
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    for (const auto& point : contour)
        if (point.zone == zone) normal += row(point) * row(point).transpose();
    const Eigen::Matrix3d inverse = normal.inverse();
    for (std::size_t i = 0; i < contour.size(); ++i) {
        if (contour[i].zone != zone) continue;
        const Eigen::Vector3d by = inverse * row(contour[i]);
        for (Eigen::Index k = 0; k < 3; ++k)
            edge.slopes[static_cast<std::size_t>(k)].add(i, by[k]);
    }
}

/// A fit whose contour is the section moved along its normals by `deviation(point)`.
template <class Deviation>
fitting::SectionFit fit_of(const Section& section, const Shape& shape, const Deviation& deviation) {
    fitting::SectionFit fit;
    fit.noise_sigma_mm = 0.001;
    fit.contour = section.contour();
    for (auto& point : fit.contour) {
        const bool edge = point.zone == Zone::le || point.zone == Zone::te;
        point.u95_mm = edge ? 0.0012 : 0.0007;
        point.position_mm += deviation(point) * point.normal;
    }
    const auto arc = [](const Vector2d& centre, double radius) {
        fitting::EdgeFit edge;
        edge.valid = true;
        edge.centre_mm = centre;
        edge.radius_mm = radius;
        edge.radius_u95_mm = 0.0021;
        edge.arc_angle_rad = core::rad_from_deg(152.0);
        edge.rms_mm = 0.0011;
        edge.used_in_contour = true;
        return edge;
    };
    fit.le = arc(section.edge_centre(0.0), shape.le_radius_mm);
    fit.te = arc(section.edge_centre(1.0), shape.te_radius_mm);
    answer_by_circle(fit.contour, Zone::le, fit.le);
    answer_by_circle(fit.contour, Zone::te, fit.te);
    fit.le_point_mm = section.nose();
    fit.te_point_mm = section.tail();
    fit.chord_mm = (fit.te_point_mm - fit.le_point_mm).norm();
    return fit;
}

/// Ball centres about a fit with noise and, every `bad_every` points, a rejected one; verdicts set in the fit.
inline std::vector<RecordedPoint> points_of(fitting::SectionFit& fit, double ball_radius_mm, double z_mm,
                                            std::uint64_t first_sequence, std::size_t bad_every, std::uint64_t seed) {
    std::vector<RecordedPoint> points;
    core::Rng rng(seed);
    for (std::size_t i = 0; i < fit.contour.size(); i += 6) {
        const auto& on = fit.contour[i];
        RecordedPoint point;
        point.sequence = first_sequence + points.size();
        double along = ball_radius_mm + 0.001 * rng.normal();
        if (bad_every > 0 && points.size() % bad_every == bad_every / 2) {
            point.verdict.residual_mm = rng.uniform(0.03, 0.35) * (rng.uniform() < 0.3 ? -1.0 : 1.0);
            point.verdict.reason = fitting::RejectReason::fit_residual;
            along += point.verdict.residual_mm;
            ++fit.rejected;
        }
        point.centre_mm << on.position_mm + along * on.normal, z_mm;
        fit.verdicts.push_back(point.verdict);
        points.push_back(point);
    }
    return points;
}

}  // namespace cmm::acquisition::synthetic
