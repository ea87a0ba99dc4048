// SPDX-License-Identifier: Apache-2.0
#include "fitting/nominal_radius.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "fitting/circle.hpp"
#include "fitting/edge_fit.hpp"
#include "fitting/edge_starts.hpp"
#include "fitting/model_fitter.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t fitted_points = 121;
constexpr double fine_step = 0.02;      // of the edge's scale
constexpr double farthest_share = 0.2;  // of the perimeter, from the nose
constexpr double beyond_zone = 0.25;    // of its length, to either side
constexpr int most_arc_rounds = 20;
constexpr double same_arc = 1e-4;

tl::unexpected<core::Error> refuse(const std::string& why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, "of the nominal section: " + why);
}

/// Where the nominal has turned by so much, from the nose on; `direction` 1: counter-clockwise, -1: clockwise.
std::optional<double> turned_from(const ClosedCurve& curve, double nose_mm, double scale_mm, double turn_rad,
                                  int direction) {
    const double step = direction * fine_step * scale_mm;
    double turned = 0.0, at = nose_mm;
    Vec2 normal = curve.evaluate(at).normal;
    while (std::abs(at - nose_mm) < farthest_share * curve.length()) {
        const Vec2 next = curve.evaluate(at + step).normal;
        const double turn = direction * turn_between(normal, next);
        if (turned + turn >= turn_rad) return at + step * (turn_rad - turned) / turn;
        turned += turn;
        at += step;
        normal = next;
    }
    return {};
}

/// The way of a ball's centre along a stretch of the nominal.
class BallWay {
  public:
    BallWay(const ClosedCurve& curve, double from_mm, double to_mm, double ball_mm) : curve_(curve), ball_mm_(ball_mm) {
        Vec2 before = Vec2::Zero();
        for (std::size_t k = 0; k <= steps; ++k) {
            at_mm_[k] = from_mm + (to_mm - from_mm) * static_cast<double>(k) / static_cast<double>(steps);
            const Vec2 centre = at(at_mm_[k]).centre;
            if (k > 0) rolled_mm_[k] = rolled_mm_[k - 1] + (centre - before).norm();
            before = centre;
        }
    }

    double length_mm() const { return rolled_mm_.back(); }
    /// From the stretch's beginning to a place on it.
    double rolled_to(double at_mm) const { return inverse(at_mm, at_mm_, rolled_mm_); }
    /// By equal steps of the centre.
    EdgePoints points(double from_rolled_mm, double to_rolled_mm) const {
        EdgePoints edge;
        edge.ball_mm = ball_mm_;
        edge.nose = fitted_points / 2;
        for (std::size_t i = 0; i < fitted_points; ++i) {
            const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(fitted_points);
            edge.points.push_back(
                at(inverse(from_rolled_mm + share * (to_rolled_mm - from_rolled_mm), rolled_mm_, at_mm_)));
        }
        return edge;
    }

  private:
    static constexpr std::size_t steps = 400;
    using Table = std::array<double, steps + 1>;

    EdgePoint at(double at_mm) const {
        const CurvePoint point = curve_.evaluate(at_mm);
        return {point.position + ball_mm_ * point.normal, point.normal};
    }
    static double inverse(double wanted, const Table& of, const Table& is) {
        const auto above = std::upper_bound(of.begin() + 1, of.end() - 1, wanted);
        const auto k = static_cast<std::size_t>(above - of.begin());
        return is[k - 1] + (wanted - of[k - 1]) / (of[k] - of[k - 1]) * (is[k] - is[k - 1]);
    }

    const ClosedCurve& curve_;
    double ball_mm_;
    Table at_mm_{}, rolled_mm_{};
};

/// Of an edge's radius.
struct NoseCircle {
    Vec2 centre_mm;
    double radius_mm;
};

/// As of a measured edge: a conic's is that of its vertex.
NoseCircle circle_of(const ArcShape& shape, const Vec2& /*nose*/) {
    return {shape.values().head<2>(), shape.values()[2]};
}
template <class Conic>
NoseCircle circle_of(const Conic& shape, const Vec2& /*nose*/) {
    const auto& v = shape.values();
    return {v.template head<2>() - v[3] * Vec2(std::cos(v[2]), std::sin(v[2])), v[3]};
}
NoseCircle circle_of(const DoubleArcShape& shape, const Vec2& nose) {
    const auto& v = shape.values();
    const bool second = cross(Vec2(std::cos(v[4]), std::sin(v[4])), nose) > 0.0;
    return second ? NoseCircle{shape.second_centre(), v[3]} : NoseCircle{v.head<2>(), v[2]};
}

template <class Shape>
core::Result<NoseCircle> fitted(ModelFitter& fitter, const std::optional<Shape>& start, const Vec2& nose) {
    if (!start) return refuse("its edge has no circle to begin with");
    const auto fit = fitter.fit(*start, {0, fitted_points});
    if (!fit.converged) return refuse("the form of the part's edge does not go through its edge");
    return circle_of(fit.shape, nose);
}

core::Result<NoseCircle> by_model(const EdgePoints& edge, EdgeModel model, const Vec2& nose) {
    ModelFitter fitter(edge);
    const EdgeWindow all{0, fitted_points};
    switch (model) {
        case EdgeModel::arc:
            return fitted(fitter, arc_start(fitter, all), nose);
        case EdgeModel::parabola:
            return fitted(fitter, vertex_start(fitter, all), nose);
        case EdgeModel::double_arc:
            return fitted(fitter, two_arcs_start(fitter, all), nose);
        case EdgeModel::ellipse:
        case EdgeModel::free:
            break;
    }
    return fitted(fitter, round_start(fitter, all), nose);
}

core::Result<Circle> circle_through(const EdgePoints& edge) {
    std::vector<Vec2> centres;
    for (const EdgePoint& point : edge.points)
        centres.push_back(point.centre);
    return fit_circle(centres);
}

/// About that of the ball, which says how the points lie: so far is the nearest centre from the nose.
double ball_radius(const SectionFit& fit, const Vec2& nose) {
    double nearest = HUGE_VAL;
    for (const Vec2& centre : fit.centres.points)
        nearest = std::min(nearest, (centre - nose).norm());
    return std::isfinite(nearest) ? nearest : 0.0;
}

/// Through the middle of the edge zone, so much of it that the circle is as long as that of the part.
core::Result<NoseCircle> of_mean_circle(const ClosedCurve& curve, const ZoneSpan& zone, double arc_rad,
                                        double ball_mm) {
    const double beyond_mm = beyond_zone * (zone.to_mm - zone.from_mm);
    const BallWay way(curve, zone.from_mm - beyond_mm, zone.to_mm + beyond_mm, ball_mm);
    const double from_mm = way.rolled_to(zone.from_mm), to_mm = way.rolled_to(zone.to_mm);
    const double middle_mm = 0.5 * (from_mm + to_mm);
    double half_mm = 0.5 * mean_circle_share * (to_mm - from_mm);
    for (int round = 0; round < most_arc_rounds; ++round) {
        const auto circle = circle_through(way.points(middle_mm - half_mm, middle_mm + half_mm));
        if (!circle) return refuse(circle.error().message);
        const double share = arc_rad / circle->arc_angle;
        if (std::abs(share - 1.0) < same_arc) return NoseCircle{circle->centre, circle->radius - ball_mm};
        half_mm = std::min(half_mm * share, std::min(middle_mm, way.length_mm() - middle_mm));
    }
    return refuse("no mean circle takes as much of its edge as the part's does");
}

core::Result<NoseCircle> circle_of_edge(const NominalSection& nominal, EdgeName edge, const SectionFit& fit) {
    const bool le = edge == EdgeName::le;
    const EdgeFit& measured = le ? fit.le : fit.te;
    if (!measured.valid) return refuse("the part's edge has no radius to compare with");
    const double ball_mm = ball_radius(fit, le ? fit.le_point_mm : fit.te_point_mm);
    const ClosedCurve& curve = nominal.curve();
    if (measured.model == EdgeModel::free)
        return of_mean_circle(curve, le ? nominal.le_span() : nominal.te_span(), measured.arc_angle_rad, ball_mm);
    const double nose_mm = le ? nominal.le_mm() : nominal.te_mm();
    const double scale_mm = le ? nominal.le_radius_mm() : nominal.te_radius_mm();
    const auto before = turned_from(curve, nose_mm, scale_mm, 0.5 * measured.arc_angle_rad, -1);
    const auto behind = turned_from(curve, nose_mm, scale_mm, 0.5 * measured.arc_angle_rad, 1);
    if (!before || !behind) return refuse("its edge does not turn as far as the part's does");
    const BallWay way(curve, *before, *behind, ball_mm);
    return by_model(way.points(0.0, way.length_mm()), measured.model, curve.evaluate(nose_mm).normal);
}

}  // namespace

core::Result<double> nominal_radius(const NominalSection& nominal, EdgeName edge, const SectionFit& fit) {
    return circle_of_edge(nominal, edge, fit).map([](const NoseCircle& circle) { return circle.radius_mm; });
}

core::Result<double> nominal_rad_center(const NominalSection& nominal, const SectionFit& fit) {
    const auto le = circle_of_edge(nominal, EdgeName::le, fit), te = circle_of_edge(nominal, EdgeName::te, fit);
    if (!le) return tl::unexpected(le.error());
    if (!te) return tl::unexpected(te.error());
    return (te->centre_mm - le->centre_mm).norm() + le->radius_mm + te->radius_mm;
}

}  // namespace cmm::fitting
