// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/section_result.hpp"
#include "fitting/section.hpp"

/// The pictures of a section and of a part as SVG text, to be put into a page that has svg::figure_style. Empty where
/// there is nothing to draw. Pure functions.
namespace cmm::acquisition {

/// Nominal, measured contour and recorded points less the ball radius; rejected ones crossed.
std::string overlay_figure(const SectionResult& section, double ball_radius_mm);
/// The same at one edge, magnified, with tolerance band and fitted circle. `edge` is le or te.
std::string edge_figure(const SectionResult& section, fitting::Zone edge, double ball_radius_mm);
/// "r 0.4003 ± 0.0021 mm, arc of 134 deg, rms 0.6 um" of the fitted circle, or why there is none.
std::string radius_text(const SectionResult& section, fitting::Zone edge);
/// Magnified deviations on the nominal with the tolerance band. Needs a nominal.
std::string whisker_figure(const SectionResult& section);
/// Deviation against arc length with zones, U95 and limits. Needs a nominal.
std::string deviation_figure(const SectionResult& section);
/// A characteristic over z.
std::string trend_figure(const PartResult& part, std::string_view characteristic);

/// The deviations of all sections in colours: each a strip, cut open at the TE, arc length from the LE nose (right:
/// counter-clockwise) against z. Between the strips nothing is filled in; what the ball does not reach is grey.
/// The scale ends at the widest limit of any place. Needs a nominal.
std::string map_figure(const PartResult& part);

/// The limits that hold at each contour point: those of the nominal's points and half the width of the zone, the
/// nearer one where there are both; none where there is neither.
std::vector<std::optional<PointTolerance>> limits_along(const SectionResult& section);
/// Width of the tolerance zone in each fitting::Zone, where there is one.
using ZoneLimits = std::array<std::optional<double>, 4>;
ZoneLimits zone_limits_mm(const SectionResult& section);

}  // namespace cmm::acquisition
