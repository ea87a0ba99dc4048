// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace cmm::fitting {

/// How the ball is taken off a section (docs/compensation.md).
enum class CompensationMethod : std::uint8_t {
    surface,      ///< SurfaceCompensation and compensate_section
    flat,         ///< offset_inwards of each section's curve of ball centres
    micro_plane,  ///< the others: contact_points.hpp
    mean_vector,
    two_pass,
    three_points,
    point_distance,
};
/// "3d", "2d", "micro_plane", "mean_vector", "two_pass", "three_points", "point_distance".
std::string_view to_string(CompensationMethod method) noexcept;
std::optional<CompensationMethod> compensation_method_from(std::string_view name) noexcept;
/// All names, in the order of the enumerators.
std::span<const std::string_view> compensation_method_names() noexcept;
/// For readers: "3-D compensation", "compensation by micro-plane".
std::string_view words_for(CompensationMethod method) noexcept;
/// Neither "3d" nor "2d".
bool is_point_by_point(CompensationMethod method) noexcept;
/// Its normals tell the lean; of the others all that is known of it is the nominal's.
bool knows_lean(CompensationMethod method) noexcept;
/// The lean comes from the sections below and above.
bool needs_neighbours(CompensationMethod method) noexcept;

}  // namespace cmm::fitting
