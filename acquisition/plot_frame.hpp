// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>
#include <vector>

#include "acquisition/svg.hpp"

namespace cmm::acquisition::svg {

/// The rectangle of a plot in the picture and the values at its borders; y grows upwards in values.
class PlotFrame {
  public:
    PlotFrame(const Vector2d& corner_px, const Vector2d& size_px, const Vector2d& low, const Vector2d& high)
        : corner_(corner_px), size_(size_px), low_(low), high_(high) {}
    /// As much of a plane as fits with the same scale in both directions, `low` to `high` inside and centred.
    static PlotFrame equal(const Vector2d& corner_px, const Vector2d& size_px, const Vector2d& low,
                           const Vector2d& high);

    Vector2d px(const Vector2d& value) const {
        return {corner_.x() + (value.x() - low_.x()) * scale_x(), corner_.y() + (high_.y() - value.y()) * scale_y()};
    }
    std::vector<Vector2d> px(std::span<const Vector2d> values) const;
    double scale_x() const { return size_.x() / (high_.x() - low_.x()); }
    double scale_y() const { return size_.y() / (high_.y() - low_.y()); }
    const Vector2d& corner() const { return corner_; }
    const Vector2d& size() const { return size_; }
    double right_px() const { return corner_.x() + size_.x(); }
    double bottom_px() const { return corner_.y() + size_.y(); }

    /// Grid lines with their labels, axis titles (with units), the frame; `draw_axes` is all of it.
    /// Without labels in the last `clear_px`, where the next frame begins.
    void draw_x_ticks(Picture& picture, int about, double clear_px = 0.0) const;
    void draw_y_ticks(Picture& picture, int about, bool labels = true) const;
    void draw_titles(Picture& picture, std::string_view x_title, std::string_view y_title) const;
    void draw_axes(Picture& picture, std::string_view x_title, std::string_view y_title, int x_ticks,
                   int y_ticks) const;

  private:
    Vector2d corner_, size_, low_, high_;
};

}  // namespace cmm::acquisition::svg
