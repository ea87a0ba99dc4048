// SPDX-License-Identifier: Apache-2.0
#include "fitting/area_measures.hpp"

#include <cmath>

#include "fitting/cyclic.hpp"

namespace cmm::fitting {
namespace {

/// Area and first moments about a near origin. Between two points the contour bulges from its chord by the segment that
/// its tangents span: chord^2 (a - b)/12, a and b the angles of the tangents to the chord (cubic of Hermite).
struct Moments {
    double area = 0.0;
    Vec2 first = Vec2::Zero();

    void add(const Vec2& a, const Vec2& b, const Vec2& tangent_a, const Vec2& tangent_b) {
        const double triangle = 0.5 * cross(a, b);
        area += triangle;
        first += triangle / 3.0 * (a + b);
        const Vec2 chord = b - a;
        const double bulge = chord.norm() * cross(tangent_a - tangent_b, chord) / 12.0;
        area += bulge;
        first += bulge * 0.5 * (a + b);
    }
};

}  // namespace

AreaMeasures measure_area(const MeasuredSection& section) {
    const auto points = section.contour().points();
    const std::size_t n = points.size();
    const Vec2 origin = points[0].position_mm;
    Moments sum;
    for (std::size_t i = 0; i < n; ++i) {
        const ContourPoint &a = points[i], &b = points[cyclic(i + 1, n)];
        sum.add(a.position_mm - origin, b.position_mm - origin, left_of(a.normal), left_of(b.normal));
    }
    const Vec2 centre = sum.first / sum.area;
    AreaMeasures out{{"AREA: Green's theorem on the contour", sum.area, {}, {}},
                     {"CENTROID: Green's theorem on the contour", origin.x() + centre.x(), {}, {}},
                     {"CENTROID: Green's theorem on the contour", origin.y() + centre.y(), {}, {}}};
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 &before = points[cyclic(i + n - 1, n)].position_mm, &after = points[cyclic(i + 1, n)].position_mm;
        const Vec2& p = points[i].position_mm;
        const double width = 0.5 * ((p - before).norm() + (after - p).norm());
        const Vec2 off = (p - origin - centre) / sum.area;
        out.area.slopes.add(i, width);
        out.centroid_x.slopes.add(i, width * off.x());
        out.centroid_y.slopes.add(i, width * off.y());
    }
    return out;
}

}  // namespace cmm::fitting
