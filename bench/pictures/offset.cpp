// SPDX-License-Identifier: Apache-2.0
#include "fitting/offset.hpp"

#include <cmath>
#include <numbers>

#include "bench/pictures/pictures.hpp"
#include "fitting/parallel_curve.hpp"

namespace cmm::pictures {
namespace {

constexpr double ball_mm = 3.0;

/// Five lobes; the hollows between them have a radius of 1.1 mm.
fitting::PiecewiseCubic lobes() {
    constexpr int count = 240;
    std::vector<Vector2d> points;
    for (int k = 0; k < count; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / count, r = 8.0 + 1.7 * std::cos(5.0 * angle);
        points.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    return fitting::interpolate_periodic(points, fitting::chord_parameters(points, true));
}

std::vector<Vector2d> with_loops(const fitting::ParallelCurve& curve) {
    constexpr int steps = 12;
    std::vector<Vector2d> points;
    for (const auto& stretch : curve.stretches())
        for (int k = 0; k < steps; ++k)
            points.push_back(curve.at(stretch, stretch.from + (stretch.to - stretch.from) * k / steps).position);
    return points;
}

}  // namespace

std::string offset() {
    const auto part = lobes();
    const fitting::ParallelCurve raw(part, ball_mm);
    const auto trimmed = fitting::offset_curve(part, ball_mm, 1200);
    svg::Picture picture(width_px, 560, "the way of a ball round a part with hollows that it does not reach");
    const auto frame =
        svg::PlotFrame::equal({left_px, 12}, {width_px - left_px - right_px, 500}, {-13.1, -13.1}, {13.1, 13.1});
    frame.draw_axes(picture, "x in mm", "y in mm", 8, 8);
    picture.clip(frame.corner(), frame.size());
    for (const auto& corner : trimmed.corners)
        picture.circle("arc", frame.px(corner.position), ball_mm * frame.scale_x());
    std::vector<Vector2d> surface, way;
    for (int k = 0; k < 1200; ++k)
        surface.push_back(frame.px(part.jet(part.front() + part.period() * k / 1200).position));
    for (const auto& point : trimmed.points)
        way.push_back(frame.px(point.position));
    picture.path("nominal", svg::polyline(surface, true), 2.0);
    picture.path("reject", svg::polyline(frame.px(with_loops(raw)), true), 0.8);
    picture.path("measured", svg::polyline(way, true), 2.2);
    picture.unclip();
    return picture.finish();
}

}  // namespace cmm::pictures
