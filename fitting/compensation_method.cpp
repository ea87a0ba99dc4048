// SPDX-License-Identifier: Apache-2.0
#include "fitting/compensation_method.hpp"

#include <algorithm>
#include <array>

namespace cmm::fitting {
namespace {

constexpr std::array<std::string_view, 7> method_names{"3d",       "2d",           "micro_plane",   "mean_vector",
                                                       "two_pass", "three_points", "point_distance"};
constexpr std::array<std::string_view, 7> method_words{"3-D compensation",
                                                       "2-D compensation",
                                                       "compensation by micro-plane",
                                                       "compensation by mean vector",
                                                       "compensation in two passes",
                                                       "compensation by three points on a circle",
                                                       "compensation by point distance"};

}  // namespace

std::string_view to_string(CompensationMethod method) noexcept {
    return method_names.at(static_cast<std::size_t>(method));
}

std::optional<CompensationMethod> compensation_method_from(std::string_view name) noexcept {
    const auto found = std::find(method_names.begin(), method_names.end(), name);
    if (found == method_names.end()) return std::nullopt;
    return static_cast<CompensationMethod>(found - method_names.begin());
}

std::span<const std::string_view> compensation_method_names() noexcept {
    return method_names;
}

std::string_view words_for(CompensationMethod method) noexcept {
    return method_words.at(static_cast<std::size_t>(method));
}

bool is_point_by_point(CompensationMethod method) noexcept {
    return method != CompensationMethod::surface && method != CompensationMethod::flat;
}

bool knows_lean(CompensationMethod method) noexcept {
    return method != CompensationMethod::flat && method != CompensationMethod::three_points;
}

bool needs_neighbours(CompensationMethod method) noexcept {
    return method == CompensationMethod::surface || method == CompensationMethod::micro_plane ||
           method == CompensationMethod::mean_vector || method == CompensationMethod::two_pass;
}

}  // namespace cmm::fitting
