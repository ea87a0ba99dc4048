// SPDX-License-Identifier: Apache-2.0
#include "fitting/thickness_measures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fitting/chord.hpp"

namespace cmm::fitting {
namespace {

tl::unexpected<core::Error> no_thickness(const char* why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, why);
}

/// How the arc length of the largest circle moves: where the growth of the radius vanishes. Outwards tilted sides move
/// it by the mean slope over the bend of the radius.
void add_arc_move(const ContourGeometry& contour, const CamberLine::Thickest& thickest, double weight,
                  Sensitivity& number) {
    const auto side = [&](const ContourPlace& place) {
        const double sense = left_of(contour.normal(place)).dot(thickest.along) > 0.0 ? 1.0 : -1.0;
        contour.add_slope(place, -0.5 * weight * sense / thickest.bend, number);
    };
    side(thickest.circle.on_suction);
    side(thickest.circle.on_pressure);
}

/// Where the line through a place of the camber line, across it, leaves on one side.
core::Result<ContourPlace> leave(const ContourGeometry& contour, const CamberPlace& place, const ContourRange& side,
                                 const Vec2& across) {
    const ContourPlace found = contour.crossing(place.position, across, side);
    if (found.index == contour.size()) return no_thickness("the line across the camber line does not meet both sides");
    return found;
}

}  // namespace

core::Result<Measure> measure_max_thickness(MeasuredSection& section) {
    const auto& camber = section.camber();
    if (!camber) return tl::unexpected(camber.error());
    const auto thickest = camber->thickest();
    Measure out{"MAX_INSCRIBED: diameter of the largest inscribed circle", 2.0 * thickest.circle.radius, {}, {}};
    const Vec2 left = left_of(thickest.along);
    const Vec2 across = left.dot(thickest.circle.to_suction) < 0.0 ? Vec2(-left) : left;
    thickest.circle.add_radius(section.contour(), across, 2.0, out.slopes);
    return out;
}

core::Result<Measure> measure_max_thickness_position(MeasuredSection& section, PositionMethod method) {
    const auto& camber = section.camber();
    if (!camber) return tl::unexpected(camber.error());
    const auto thickest = camber->thickest();
    if (!(thickest.bend < 0.0)) return no_thickness("the thickness has no maximum between the edges");
    const ContourGeometry& contour = section.contour();
    if (method == PositionMethod::on_camber) {
        Measure out{"MAX_INSCRIBED along the camber line, share of its length from the LE",
                    thickest.arc_mm / camber->length_mm(),
                    {},
                    {}};
        add_arc_move(contour, thickest, 1.0 / camber->length_mm(), out.slopes);
        camber->le().add(contour, -(1.0 - out.value) / camber->length_mm() * camber->le().inward(), out.slopes);
        camber->te().add(contour, out.value / camber->length_mm() * camber->te().inward(), out.slopes);
        return out;
    }
    const Vec2 step = camber->te().point() - camber->le().point();
    const double chord = step.norm();
    const Vec2 along = step / chord, off = thickest.circle.centre - camber->le().point();
    Measure out{"MAX_INSCRIBED, its centre projected on the chord NOSETAIL, share of the chord from the LE",
                off.dot(along) / chord,
                {},
                {}};
    add_arc_move(contour, thickest, thickest.along.dot(along) / chord, out.slopes);
    const Vec2 left = left_of(thickest.along);
    const Vec2 across = left.dot(thickest.circle.to_suction) < 0.0 ? Vec2(-left) : left;
    thickest.circle.add_shift(contour, across, across.dot(along) / chord, out.slopes);
    // x = off . step / step^2
    const Vec2 by_step = (off - 2.0 * out.value * step) / step.squaredNorm(), by_off = step / step.squaredNorm();
    camber->te().add(contour, by_step, out.slopes);
    camber->le().add(contour, -by_step - by_off, out.slopes);
    return out;
}

core::Result<Measure> measure_edge_thickness(MeasuredSection& section, EdgeName edge, double distance_mm) {
    const auto& camber = section.camber();
    if (!camber) return tl::unexpected(camber.error());
    const CamberEnd& end = edge == EdgeName::le ? camber->le() : camber->te();
    const auto place = camber->at_distance(end, distance_mm);
    if (!place) return tl::unexpected(place.error());
    const ContourGeometry& contour = section.contour();
    const Vec2 across = left_of(place->inward);
    // On either side of the line: what lies behind the place has the other sense.
    std::array<ContourPlace, 2> ends;
    const std::array<ContourRange, 2> sides{camber->sides().suction, camber->sides().pressure};
    Measure out{"TIPARC, NORMAL: across the camber line at the distance from the edge's point", 0.0, {}, {}};
    double growth = 0.0;  // of the thickness, by a move of the line inwards
    for (std::size_t k = 0; k < 2; ++k) {
        const auto found = leave(contour, *place, sides[k], across);
        if (!found) return tl::unexpected(found.error());
        ends[k] = *found;
        const Vec2 off = contour.position(ends[k]) - place->position, normal = contour.normal(ends[k]);
        const Vec2 out_of = off.dot(across) < 0.0 ? Vec2(-across) : across;
        const double leaning = normal.dot(out_of);
        if (leaning < 0.1) return no_thickness("the line across the camber line runs along a side");
        out.value += off.norm();
        contour.add(ends[k], 1.0 / leaning, out.slopes);
        growth -= normal.dot(place->inward) / leaning;
    }
    if ((contour.position(ends[0]) - place->position).dot(contour.position(ends[1]) - place->position) > 0.0)
        return no_thickness("the line across the camber line meets both sides on one hand");
    end.add(contour, growth * place->inward, out.slopes);
    return out;
}

core::Result<Measure> measure_edge_angle(MeasuredSection& section, EdgeName edge, double near_mm, double far_mm,
                                         AngleReference reference) {
    const auto& camber = section.camber();
    if (!camber) return tl::unexpected(camber.error());
    const CamberEnd& end = edge == EdgeName::le ? camber->le() : camber->te();
    const auto near = camber->at_distance(end, near_mm), far = camber->at_distance(end, far_mm);
    if (!near) return tl::unexpected(near.error());
    if (!far) return tl::unexpected(far.error());
    const ContourGeometry& contour = section.contour();
    const double sense = edge == EdgeName::le ? 1.0 : -1.0;
    const Vec2 step = far->position - near->position;
    Measure out{"ANGOFFSET from +x: direction of the camber line between two distances from the edge's point",
                std::atan2(sense * step.y(), sense * step.x()),
                {},
                {}};
    const Vec2 across = left_of(step) / step.squaredNorm();  // of the angle, by a move of the far place
    out.slopes.add(far->across, across.dot(left_of(far->inward)));
    out.slopes.add(near->across, -across.dot(left_of(near->inward)));
    // Both places move along the line with the edge's point.
    end.add(contour, across.dot(far->inward) * far->inward - across.dot(near->inward) * near->inward, out.slopes);
    if (reference == AngleReference::chord) {
        out.method =
            "ANGOFFSET from the chord NOSETAIL: direction of the camber line between two distances from the "
            "edge's point";
        const auto chord = measure_stagger(section, StaggerMethod::nose_tail);
        if (!chord) return tl::unexpected(chord.error());
        out.value = std::remainder(out.value - chord->value, 2.0 * std::numbers::pi);
        out.slopes.add(chord->slopes, -1.0);
    }
    return out;
}

}  // namespace cmm::fitting
