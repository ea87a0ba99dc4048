// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "bench/pictures/pictures.hpp"

namespace cmm::pictures {

svg::PlotFrame frame_at(double top_px, double height_px, const Vector2d& low, const Vector2d& high) {
    return {{left_px, top_px}, {width_px - left_px - right_px, height_px}, low, high};
}

std::vector<Vector2d> graph(const svg::PlotFrame& frame, std::span<const double> x, std::span<const double> y) {
    std::vector<Vector2d> pixels;
    for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
        pixels.push_back(frame.px({x[i], y[i]}));
    return pixels;
}

std::vector<double> lengths(std::span<const Vector2d> points) {
    std::vector<double> s{0.0};
    for (std::size_t i = 1; i < points.size(); ++i)
        s.push_back(s.back() + (points[i] - points[i - 1]).norm());
    return s;
}

}  // namespace cmm::pictures
