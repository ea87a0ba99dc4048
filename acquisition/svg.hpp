// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Drawing in pixels for the report: paths, texts, axes. Text functions, no state but the picture that grows.
namespace cmm::acquisition::svg {

using Eigen::Vector2d;

/// For element content and attributes of XML and HTML; control characters are dropped.
std::string escape(std::string_view text);
/// Two decimals at most: a hundredth of a pixel is invisible.
std::string number(double pixels);

/// Path data of a polyline, thinned so that no dropped point was more than `thinning_px` off. Wide lines need less.
std::string polyline(std::span<const Vector2d> pixels, bool closed, double thinning_px = 0.05);
/// Path data of dots (drawn by round line caps) and of crosses.
std::string dots(std::span<const Vector2d> pixels);
std::string crosses(std::span<const Vector2d> pixels, double half_px);

/// Round tick values that cover [low, high].
struct Ticks {
    std::vector<double> values;
    int digits = 0;
};
Ticks ticks(double low, double high, int about);
/// The largest of 1, 2, 5 times a power of ten that is not above `value`.
double round_down(double value);

enum class Anchor { start, middle, end };

/// One picture. Classes are styled by `figure_style`.
class Picture {
  public:
    Picture(double width_px, double height_px, std::string_view description);
    /// `stroke_px` overrides the class's width.
    void path(std::string_view css, const std::string& data, double stroke_px = 0.0);
    /// An area of one colour ("#rrggbb"), whatever the style.
    void fill(std::string_view colour, const std::string& data);
    void line(std::string_view css, const Vector2d& from, const Vector2d& to);
    void box(std::string_view css, const Vector2d& corner, const Vector2d& size);
    void circle(std::string_view css, const Vector2d& centre, double radius_px);
    void text(std::string_view css, const Vector2d& at, Anchor anchor, std::string_view words, bool upwards = false);
    /// What follows until `unclip` is cut at the box.
    void clip(const Vector2d& corner, const Vector2d& size);
    void unclip();
    std::string finish() const;

  private:
    double width_px_;
    double height_px_;
    std::string description_;
    std::string body_;
};

/// The style of the classes, light and dark, as CSS text.
std::string_view figure_style();
/// A finished picture for a renderer that knows no variables of CSS: the light style inside, every colour a number.
std::string on_paper(const std::string& picture);
/// A finished picture with its style inside: a file of its own.
std::string standalone(const std::string& picture);

}  // namespace cmm::acquisition::svg
