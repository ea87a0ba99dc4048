// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_starts.hpp"

#include <cmath>
#include <limits>
#include <span>

#include "fitting/circle.hpp"

namespace cmm::fitting {
namespace {

std::optional<Circle> circle_of(const ModelFitter& fitter, const EdgeWindow& w) {
    const auto circle = fit_circle_kasa(std::span(fitter.centres()).subspan(w.begin, w.count()));
    if (!circle || !(circle->radius > fitter.ball_mm())) return {};
    return *circle;
}

double squares_about(const ModelFitter& fitter, const Circle& circle, const EdgeWindow& w) {
    double sum = 0.0;
    for (std::size_t i = w.begin; i < w.end; ++i)
        sum += std::pow((fitter.centres()[i] - circle.centre).norm() - circle.radius, 2);
    return sum;
}

}  // namespace

std::optional<ArcShape> arc_start(const ModelFitter& fitter, const EdgeWindow& window) {
    const auto circle = circle_of(fitter, window);
    if (!circle) return {};
    ArcShape::Values values;
    values << circle->centre, circle->radius - fitter.ball_mm();
    return ArcShape(values);
}

std::optional<ParabolaShape> vertex_start(const ModelFitter& fitter, const EdgeWindow& window) {
    const auto circle = circle_of(fitter, window);
    if (!circle) return {};
    Vec2 axis = Vec2::Zero();
    for (std::size_t i = window.begin; i < window.end; ++i)
        axis += fitter.edge().points[i].normal;
    axis.normalize();
    const double radius = circle->radius - fitter.ball_mm();
    ParabolaShape::Values values;
    values << circle->centre + radius * axis, std::atan2(axis.y(), axis.x()), radius;
    return ParabolaShape(values);
}

std::optional<EllipseShape> round_start(const ModelFitter& fitter, const EdgeWindow& window) {
    const auto vertex = vertex_start(fitter, window);
    if (!vertex) return {};
    EllipseShape::Values values;
    values << vertex->values(), 1.0;
    return EllipseShape(values);
}

std::optional<DoubleArcShape> two_arcs_start(const ModelFitter& fitter, const EdgeWindow& window) {
    std::optional<DoubleArcShape> best;
    double least = std::numeric_limits<double>::infinity();
    for (const double share : {0.3, 0.5, 0.7}) {
        const auto split = window.begin + static_cast<std::size_t>(share * static_cast<double>(window.count()));
        const EdgeWindow before{window.begin, split}, after{split, window.end};
        const auto first = circle_of(fitter, before), second = circle_of(fitter, after);
        if (!first || !second) continue;
        const double squares = squares_about(fitter, *first, before) + squares_about(fitter, *second, after);
        if (squares >= least) continue;
        least = squares;
        const Vec2& meeting = fitter.edge().points[split].normal;
        DoubleArcShape::Values values;
        values << first->centre, first->radius - fitter.ball_mm(), second->radius - fitter.ball_mm(),
            std::atan2(meeting.y(), meeting.x());
        best = DoubleArcShape(values);
    }
    return best;
}

}  // namespace cmm::fitting
