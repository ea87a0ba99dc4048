// SPDX-License-Identifier: Apache-2.0
#include "acquisition/plot_frame.hpp"

#include <algorithm>

#include "core/text.hpp"

namespace cmm::acquisition::svg {

PlotFrame PlotFrame::equal(const Vector2d& corner_px, const Vector2d& size_px, const Vector2d& low,
                           const Vector2d& high) {
    const Vector2d extent = high - low;
    const double mm_per_px = std::max(extent.x() / size_px.x(), extent.y() / size_px.y());
    const Vector2d half = 0.5 * mm_per_px * size_px;
    const Vector2d middle = 0.5 * (low + high);
    return {corner_px, size_px, middle - half, middle + half};
}

std::vector<Vector2d> PlotFrame::px(std::span<const Vector2d> values) const {
    std::vector<Vector2d> pixels;
    pixels.reserve(values.size());
    for (const auto& value : values)
        pixels.push_back(px(value));
    return pixels;
}

void PlotFrame::draw_x_ticks(Picture& picture, int about, double clear_px) const {
    const auto across = ticks(low_.x(), high_.x(), about);
    for (const double x : across.values) {
        const double at = px({x, low_.y()}).x();
        picture.line("grid", {at, corner_.y()}, {at, bottom_px()});
        if (at > right_px() - clear_px) continue;
        picture.text("", {at, bottom_px() + 14}, Anchor::middle, core::fixed(x, across.digits));
    }
    picture.box("frame", corner_, size_);
}

void PlotFrame::draw_y_ticks(Picture& picture, int about, bool labels) const {
    const auto up = ticks(low_.y(), high_.y(), about);
    for (const double y : up.values) {
        const double at = px({low_.x(), y}).y();
        picture.line("grid", {corner_.x(), at}, {right_px(), at});
        if (labels) picture.text("", {corner_.x() - 6, at + 4}, Anchor::end, core::fixed(y, up.digits));
    }
}

void PlotFrame::draw_titles(Picture& picture, std::string_view x_title, std::string_view y_title) const {
    picture.text("", {corner_.x() + 0.5 * size_.x(), bottom_px() + 29}, Anchor::middle, x_title);
    picture.text("", {corner_.x() - 45, corner_.y() + 0.5 * size_.y()}, Anchor::middle, y_title, true);
}

void PlotFrame::draw_axes(Picture& picture, std::string_view x_title, std::string_view y_title, int x_ticks,
                          int y_ticks) const {
    draw_x_ticks(picture, x_ticks);
    draw_y_ticks(picture, y_ticks);
    draw_titles(picture, x_title, y_title);
}

}  // namespace cmm::acquisition::svg
