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

void PlotFrame::draw_axes(Picture& picture, std::string_view x_title, std::string_view y_title, int x_ticks,
                          int y_ticks) const {
    const auto across = ticks(low_.x(), high_.x(), x_ticks);
    for (const double x : across.values) {
        const double at = px({x, low_.y()}).x();
        picture.line("grid", {at, corner_.y()}, {at, bottom_px()});
        picture.text("", {at, bottom_px() + 14}, Anchor::middle, core::fixed(x, across.digits));
    }
    const auto up = ticks(low_.y(), high_.y(), y_ticks);
    for (const double y : up.values) {
        const double at = px({low_.x(), y}).y();
        picture.line("grid", {corner_.x(), at}, {right_px(), at});
        picture.text("", {corner_.x() - 6, at + 4}, Anchor::end, core::fixed(y, up.digits));
    }
    picture.box("frame", corner_, size_);
    picture.text("", {corner_.x() + 0.5 * size_.x(), bottom_px() + 29}, Anchor::middle, x_title);
    picture.text("", {corner_.x() - 40, corner_.y() + 0.5 * size_.y()}, Anchor::middle, y_title, true);
}

}  // namespace cmm::acquisition::svg
