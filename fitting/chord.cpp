// SPDX-License-Identifier: Apache-2.0
#include "fitting/chord.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "fitting/enclosing_circle.hpp"

namespace cmm::fitting {
namespace {

constexpr int most_turns = 40;           // of the line that touches both ends
constexpr double nearest_touches = 0.3;  // of the chord, between them: nearer, the side is not concave

tl::unexpected<core::Error> no_chord(const std::string& why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, why);
}

/// The line that touches the pressure side at both ends.
struct Bitangent {
    ContourPlace at_le, at_te;
    Vec2 along = Vec2::UnitX();  ///< unit, LE to TE
    Vec2 outward = Vec2::UnitY();
    double length_mm = 0.0;  ///< between the places
};

core::Result<Bitangent> touch_concave_side(const MeasuredSection& section) {
    const ContourGeometry& contour = section.contour();
    const SectionSides sides = SectionSides::of(section.fit(), contour);
    const ContourRange side = sides.pressure;
    const bool from_le = side.first == sides.le;
    const std::size_t half = side.count / 2;
    const ContourRange first{side.first, half + 1}, second{side.first + half, side.count - half};
    const ContourRange &le = from_le ? first : second, &te = from_le ? second : first;
    Bitangent line;
    const Vec2 chord = section.fit().te_point_mm - section.fit().le_point_mm;
    line.along = chord.normalized();
    // Counter-clockwise the material is on the left: on the side that runs LE -> TE outwards is to the right.
    const auto outward_of = [&](const Vec2& along) { return from_le ? right_normal(along) : left_of(along); };
    for (int turn = 0; turn < most_turns; ++turn) {
        line.outward = outward_of(line.along);
        line.at_le = contour.farthest(line.outward, le);
        line.at_te = contour.farthest(line.outward, te);
        const Vec2 step = contour.position(line.at_te) - contour.position(line.at_le);
        line.length_mm = step.norm();
        if (line.length_mm < nearest_touches * chord.norm())
            return no_chord("the pressure side is not concave: no line touches it at both ends");
        const Vec2 along = step / line.length_mm;
        const bool still = std::abs(cross(along, line.along)) < 1e-13;
        line.along = along;
        if (still) break;
    }
    return line;
}

/// Of the direction of the line, rad.
void add_turn(const ContourGeometry& contour, const Bitangent& line, double weight, Sensitivity& number) {
    const double share = weight / line.length_mm * (cross(line.along, line.outward) > 0.0 ? 1.0 : -1.0);
    contour.add(line.at_te, share, number);
    contour.add(line.at_le, -share, number);
}

/// The extent along a direction; how it answers to a turn of the direction, mm/rad.
struct Extent {
    Measure measure;
    double by_turn_mm = 0.0;
};

Extent extent(const ContourGeometry& contour, const Vec2& along, std::string_view method) {
    const ContourPlace high = contour.farthest(along, contour.whole());
    const ContourPlace low = contour.farthest(-along, contour.whole());
    const Vec2 step = contour.position(high) - contour.position(low);
    Extent out{{method, step.dot(along), {}, {}}, step.dot(left_of(along))};
    contour.add(high, 1.0, out.measure.slopes);
    contour.add(low, 1.0, out.measure.slopes);
    return out;
}

core::Result<Measure> nose_tail(MeasuredSection& section) {
    const auto& camber = section.camber();
    if (!camber) return tl::unexpected(camber.error());
    const Vec2 step = camber->te().point() - camber->le().point();
    Measure out{"NOSETAIL: between the points where the camber line leaves the section", step.norm(), {}, {}};
    const Vec2 along = step / out.value;
    camber->te().add(section.contour(), along, out.slopes);
    camber->le().add(section.contour(), -along, out.slopes);
    return out;
}

core::Result<Measure> caliper(const MeasuredSection& section) {
    const auto line = touch_concave_side(section);
    if (!line) return tl::unexpected(line.error());
    Extent found = extent(section.contour(), line->along,
                          "CALIPER: extent along the line that touches the pressure side at both ends");
    add_turn(section.contour(), *line, found.by_turn_mm, found.measure.slopes);
    return found.measure;
}

core::Result<Measure> rad_center(const MeasuredSection& section) {
    const EdgeFit &le = section.fit().le, &te = section.fit().te;
    if (!le.valid) return no_chord("LE: " + le.why);
    if (!te.valid) return no_chord("TE: " + te.why);
    const Vec2 step = te.centre_mm - le.centre_mm;
    const Vec2 along = step.normalized();
    Measure out{"RADCENTER: between the centres of the edges' circles, plus both radii",
                step.norm() + le.radius_mm + te.radius_mm,
                {},
                {}};
    const Eigen::Vector3d at_le(-along.x(), -along.y(), 1.0), at_te(along.x(), along.y(), 1.0);
    out.beside.variance = at_le.dot(le.covariance_mm2 * at_le) + at_te.dot(te.covariance_mm2 * at_te);
    for (std::size_t k = 0; k < 3; ++k) {
        out.beside.slopes.add(le.slopes[k], at_le[static_cast<Eigen::Index>(k)]);
        out.beside.slopes.add(te.slopes[k], at_te[static_cast<Eigen::Index>(k)]);
    }
    return out;
}

Measure min_circle(const ContourGeometry& contour) {
    const EnclosingCircle circle = enclosing_circle(contour);
    Measure out{"MINCIRCLE: diameter of the smallest circle that holds the section", 2.0 * circle.radius, {}, {}};
    for (std::size_t k = 0; k < circle.count; ++k) {
        const Vec2 away = (contour.position(circle.touches[k]) - circle.centre).normalized();
        contour.add(circle.touches[k], 2.0 * circle.shares[k] * away.dot(contour.normal(circle.touches[k])),
                    out.slopes);
    }
    return out;
}

Measure largest(const ContourGeometry& contour) {
    const auto places = farthest_places(contour);
    const double distance = (contour.position(places[1]) - contour.position(places[0])).norm();
    Measure out{"MAXDIST: largest distance of two points of the section", distance, {}, {}};
    for (const ContourPlace& place : places)
        contour.add(place, 1.0, out.slopes);
    return out;
}

}  // namespace

core::Result<Measure> measure_chord(MeasuredSection& section, ChordMethod method, double direction_rad) {
    switch (method) {
        case ChordMethod::nose_tail:
            return nose_tail(section);
        case ChordMethod::caliper:
            return caliper(section);
        case ChordMethod::belac:
            return extent(section.contour(), {std::cos(direction_rad), std::sin(direction_rad)},
                          "BELAC: extent along the given direction")
                .measure;
        case ChordMethod::x_axis:
            return extent(section.contour(), Vec2::UnitX(), "XAXIS: extent in x").measure;
        case ChordMethod::rad_center:
            return rad_center(section);
        case ChordMethod::min_circle:
            return min_circle(section.contour());
        case ChordMethod::largest:
            return largest(section.contour());
    }
    return no_chord("no such method");
}

core::Result<Measure> measure_stagger(MeasuredSection& section, StaggerMethod method) {
    if (method == StaggerMethod::caliper) {
        const auto line = touch_concave_side(section);
        if (!line) return tl::unexpected(line.error());
        Measure out{"CALIPER: of the line that touches the pressure side at both ends",
                    std::atan2(line->along.y(), line->along.x()),
                    {},
                    {}};
        add_turn(section.contour(), *line, 1.0, out.slopes);
        return out;
    }
    const auto& camber = section.camber();
    if (!camber) return tl::unexpected(camber.error());
    const Vec2 step = camber->te().point() - camber->le().point();
    Measure out{"NOSETAIL: between the points where the camber line leaves the section",
                std::atan2(step.y(), step.x()),
                {},
                {}};
    const Vec2 across = left_of(step) / step.squaredNorm();
    camber->te().add(section.contour(), across, out.slopes);
    camber->le().add(section.contour(), -across, out.slopes);
    return out;
}

}  // namespace cmm::fitting
