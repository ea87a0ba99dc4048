// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "acquisition/plot_frame.hpp"
#include "acquisition/section_result.hpp"

/// What the pictures of a section have in common: sizes in pixels, the part of the plane they show, the points in it.
namespace cmm::acquisition::figure {

using Eigen::Vector2d;

constexpr double page_width = 540;
constexpr double margin_left = 54;
constexpr double margin_right = 12;
constexpr double margin_top = 12;
constexpr double margin_bottom = 36;
constexpr double longest_whisker_px = 24;

constexpr bool is_edge(fitting::Zone zone) {
    return zone == fitting::Zone::le || zone == fitting::Zone::te;
}

struct Box {
    Vector2d low = Vector2d::Constant(std::numeric_limits<double>::max());
    Vector2d high = Vector2d::Constant(std::numeric_limits<double>::lowest());
    void add(const Vector2d& p) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    void grow(double by) {
        low.array() -= by;
        high.array() += by;
    }
};

struct SurfacePoints {
    std::vector<Vector2d> used;
    std::vector<Vector2d> rejected;
};

/// Recorded points less the ball radius along the normal of the nearest contour point; ball centres without a contour.
SurfacePoints surface_points(const SectionResult& section, double ball_radius_mm);
/// A line through what belongs to the contour's points, one for each; a gap is a gap.
std::string contour_path(const SectionResult& section, const std::vector<Vector2d>& pixels);

/// Nominal, contour and points with a little room.
Box extent_of(const SectionResult& section, const SurfacePoints& points);
/// Overlay and whiskers stand side by side: the same box, with room for the longest whisker, and the same height.
Box page_box(const SectionResult& section, const SurfacePoints& points);
double plot_height(const Box& box);
/// The box in equal scales within a picture of this size at `corner_px`, less the margins.
svg::PlotFrame plane_frame(const Box& box, const Vector2d& corner_px, double width_px, double height_px);

}  // namespace cmm::acquisition::figure
