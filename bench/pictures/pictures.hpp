// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "acquisition/plot_frame.hpp"
#include "acquisition/svg.hpp"

/// The pictures of docs/theory.md and docs/compensation.md, drawn by the code that they explain: each the text of one
/// SVG file. All but `sample_cost` come out the same on every machine.
namespace cmm::pictures {

namespace svg = acquisition::svg;
using Eigen::Vector2d;

constexpr double width_px = 640, left_px = 56, right_px = 14;

/// A plot over the whole width.
svg::PlotFrame frame_at(double top_px, double height_px, const Vector2d& low, const Vector2d& high);
/// Points of a plot whose abscissae are `x`.
std::vector<Vector2d> graph(const svg::PlotFrame& frame, std::span<const double> x, std::span<const double> y);
/// Cumulative chord length from the first point.
std::vector<double> lengths(std::span<const Vector2d> points);

/// Error of the open section at the newest sample and 16 samples later, and of the closed section with its band.
std::string live_error();
/// Error of one contour of a twisted blade by each method of compensation.
std::string compensation();
/// A leading edge: points, arc, joints, and what the points leave off the arc.
std::string edge_fit();
/// A part with hollows sharper than the ball, and the way of the ball's centre with and without its loops.
std::string offset();
/// Residuals of a scan with bad points in runs, and which of them were found.
std::string bad_points();
/// Microseconds a sample over a million samples, on this machine.
std::string sample_cost();

}  // namespace cmm::pictures
