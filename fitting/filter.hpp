// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "fitting/section.hpp"

/// Profile filters on samples at any spacing along the arc length: a sine of the cut-off wavelength keeps half its
/// height, a straight profile is kept (docs/theory.md, "Filters").
namespace cmm::fitting {

enum class FilterKind : std::uint8_t {
    none,
    gaussian,         ///< ISO 16610-21, as local regression of first order: its own end correction (ISO 16610-28)
    spline,           ///< ISO 16610-22: cubic smoothing spline
    robust_gaussian,  ///< ISO 16610-31: local regression of second order, Tukey's biweights
};
std::string_view to_string(FilterKind kind) noexcept;
std::optional<FilterKind> filter_kind_from(std::string_view name) noexcept;

struct FilterSpec {
    FilterKind kind = FilterKind::none;
    double cutoff_mm = 0.8;  ///< wavelength of which half the height passes
};

/// The filtered profile (the long waves), one value a sample. `s_mm` ascends strictly; `closed_length_mm` > 0 makes the
/// profile closed, with that length from the first sample round to itself. Errors: fit_not_evaluable (sizes differ, not
/// ascending, not finite, fewer than 5 samples, the cut-off not positive or longer than the profile).
core::Result<std::vector<double>> filter_profile(std::span<const double> s_mm, std::span<const double> values,
                                                 const FilterSpec& spec, double closed_length_mm = 0.0);

/// One filter for each zone: an edge and a side share no cut-off, because a cut-off that suits a side moves an edge of
/// radius r inwards by about (0.187 cut-off)^2 / (2 r).
struct ZoneFilters {
    std::array<FilterSpec, 4> of{};  ///< by Zone
    FilterSpec& at(Zone zone) { return of[static_cast<std::size_t>(zone)]; }
    const FilterSpec& at(Zone zone) const { return of[static_cast<std::size_t>(zone)]; }
};

/// Deviations after their zones' filters; a zone that its filter refuses (too short for the cut-off) has none.
struct FilteredZones {
    std::vector<std::optional<double>> values;  ///< by contour point
    std::array<std::string, 4> refused;         ///< by Zone: why; empty: it is filtered
};

/// Filters the values at the points of a closed contour zone by zone: each stretch of a zone that has values is an open
/// profile, so that nothing crosses a transition point or a gap. Both spans have the same size.
FilteredZones filter_zones(std::span<const ContourPoint> contour, std::span<const std::optional<double>> values,
                           const ZoneFilters& filters);

}  // namespace cmm::fitting
