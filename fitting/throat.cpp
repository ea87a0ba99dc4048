// SPDX-License-Identifier: Apache-2.0
#include "fitting/throat.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmm::fitting {
namespace {

constexpr std::size_t looked_at = 300;  // points of each blade for the first look
constexpr int most_feet = 200;
constexpr double settled_mm = 1e-9;
constexpr double least_throat_mm = 1e-3;  // less is no passage: the search ends where the outlines cross

/// The two places between which the distance is measured: of the blade, and of its neighbour before it was moved.
struct Passage {
    ContourPlace here, there;
    double width_mm = std::numeric_limits<double>::max();
};

Passage first_look(const ContourGeometry& contour, const Vec2& pitch) {
    const std::size_t stride = std::max<std::size_t>(1, contour.size() / looked_at);
    Passage best;
    for (std::size_t i = 0; i < contour.size(); i += stride) {
        for (std::size_t k = 0; k < contour.size(); k += stride) {
            const double width = (contour.point(k).position_mm + pitch - contour.point(i).position_mm).norm();
            if (width < best.width_mm) best = {{i, 0.0}, {k, 0.0}, width};
        }
    }
    return best;
}

/// Whether the neighbour reaches into the blade: there may be a smallest distance all the same, behind the place where
/// it comes out again.
bool outlines_cross(const ContourGeometry& contour, const Vec2& pitch) {
    const std::size_t stride = std::max<std::size_t>(1, contour.size() / looked_at);
    for (std::size_t k = 0; k < contour.size(); k += stride) {
        const Vec2 moved = contour.point(k).position_mm + pitch;
        const ContourPoint& nearest = contour.point(contour.nearest_point(moved));
        if ((moved - nearest.position_mm).dot(nearest.normal) < 0.0) return true;
    }
    return false;
}

}  // namespace

core::Result<Measure> measure_throat(MeasuredSection& section, const Vec2& pitch_mm) {
    const ContourGeometry& contour = section.contour();
    const auto refuse = [](const char* why) {
        return core::fail(core::ErrorCode::fit_not_evaluable, std::string("throat: ") + why);
    };
    if (outlines_cross(contour, pitch_mm)) return refuse("the neighbours cross");
    Passage passage = first_look(contour, pitch_mm);
    for (int k = 0; k < most_feet; ++k) {
        passage.there = contour.foot(contour.position(passage.here) - pitch_mm, contour.whole(), &passage.there);
        passage.here = contour.foot(contour.position(passage.there) + pitch_mm, contour.whole(), &passage.here);
        const Vec2 across = contour.position(passage.there) + pitch_mm - contour.position(passage.here);
        const double change = passage.width_mm - across.norm();
        passage.width_mm = across.norm();
        if (std::abs(change) > settled_mm) continue;
        // Where the blades touch or cross, the way from one to the other leads through material.
        if (passage.width_mm < least_throat_mm || !(across.dot(contour.normal(passage.here)) > 0.5 * passage.width_mm))
            return refuse("the neighbours touch");
        Measure out{
            "THROAT: smallest distance to the same section moved by the nominal pitch", passage.width_mm, {}, {}};
        contour.add(passage.here, -1.0, out.slopes);
        contour.add(passage.there, -1.0, out.slopes);
        return out;
    }
    return refuse("the search does not settle");
}

}  // namespace cmm::fitting
