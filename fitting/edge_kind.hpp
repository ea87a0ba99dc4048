// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace cmm::fitting {

/// The forms that drawings give to leading and trailing edges (seed 000, A10); free: none of them.
enum class EdgeModel : std::uint8_t { free, arc, ellipse, double_arc, parabola };
std::string_view to_string(EdgeModel model) noexcept;
std::optional<EdgeModel> edge_model_from(std::string_view name) noexcept;

/// Kinds of ends: round (any of the models, or free form), blunt and square (a flat between roundings or corners),
/// partial (not all of the edge was measured).
enum class EdgeForm : std::uint8_t { round, blunt, square, partial };
std::string_view to_string(EdgeForm form) noexcept;

}  // namespace cmm::fitting
