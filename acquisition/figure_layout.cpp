// SPDX-License-Identifier: Apache-2.0
#include "acquisition/figure_layout.hpp"

#include <algorithm>

namespace cmm::acquisition::figure {
namespace {

/// Good enough for a picture: every 8th point first, then the neighbours of the best.
const fitting::ContourPoint& nearest(const std::vector<fitting::ContourPoint>& contour, const Vector2d& p) {
    constexpr std::size_t stride = 8;
    const std::size_t n = contour.size();
    std::size_t best = 0;
    double best_squared = std::numeric_limits<double>::max();
    const auto look_at = [&](std::size_t i) {
        const double squared = (contour[i].position_mm - p).squaredNorm();
        if (squared >= best_squared) return;
        best_squared = squared;
        best = i;
    };
    for (std::size_t i = 0; i < n; i += stride)
        look_at(i);
    const std::size_t coarse = best;
    for (std::size_t k = 1; k < stride; ++k) {
        look_at((coarse + k) % n);
        look_at((coarse + n - k % n) % n);
    }
    return contour[best];
}

}  // namespace

SurfacePoints surface_points(const SectionResult& section, double ball_radius_mm) {
    SurfacePoints out;
    for (const auto& point : section.points) {
        Vector2d p = point.centre_mm.head<2>();
        if (section.has_contour()) {
            p -= ball_radius_mm * nearest(section.fit->contour, p).normal;
        }
        (point.verdict.reason == fitting::RejectReason::none ? out.used : out.rejected).push_back(p);
    }
    return out;
}

std::string contour_path(const SectionResult& section, const std::vector<Vector2d>& pixels) {
    const auto gaps = section.gaps();
    if (gaps.empty()) return svg::polyline(pixels, true);
    std::string path;
    for (std::size_t k = 0; k < gaps.size(); ++k) {
        const std::size_t last = gaps[(k + 1) % gaps.size()].before;
        std::vector<Vector2d> stretch{pixels[gaps[k].behind]};
        for (std::size_t i = gaps[k].behind; i != last;) {
            i = (i + 1) % pixels.size();
            stretch.push_back(pixels[i]);
        }
        path += svg::polyline(stretch, false);
    }
    return path;
}

Box extent_of(const SectionResult& section, const SurfacePoints& points) {
    Box box;
    for (const auto& p : section.nominal_contour)
        box.add(p);
    for (const auto& p : contour_positions(section))
        box.add(p);
    for (const auto& p : points.used)
        box.add(p);
    for (const auto& p : points.rejected)
        box.add(p);
    if (!(box.high - box.low).allFinite() || (box.high - box.low).minCoeff() < 0.0) box = {{-1, -1}, {1, 1}};
    box.grow(0.04 * (box.high - box.low).maxCoeff());
    return box;
}

Box page_box(const SectionResult& section, const SurfacePoints& points) {
    auto box = extent_of(section, points);
    box.grow(longest_whisker_px * (box.high - box.low).x() / page_width);
    return box;
}

double plot_height(const Box& box) {
    const Vector2d size = box.high - box.low;
    return std::clamp((page_width - margin_left - margin_right) * size.y() / size.x(), 150.0, 340.0);
}

svg::PlotFrame plane_frame(const Box& box, const Vector2d& corner_px, double width_px, double height_px) {
    return svg::PlotFrame::equal(corner_px + Vector2d(margin_left, margin_top),
                                 {width_px - margin_left - margin_right, height_px - margin_top - margin_bottom},
                                 box.low, box.high);
}

}  // namespace cmm::acquisition::figure
