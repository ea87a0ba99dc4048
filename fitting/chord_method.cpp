// SPDX-License-Identifier: Apache-2.0
#include "fitting/chord_method.hpp"

#include <array>
#include <string>
#include <utility>

#include "core/text.hpp"

namespace cmm::fitting {

std::optional<ChordMethod> chord_method_from(std::string_view keyword) {
    static constexpr std::array<std::pair<std::string_view, ChordMethod>, 10> names{
        {{"nosetail", ChordMethod::nose_tail},
         {"caliper", ChordMethod::caliper},
         {"tangent", ChordMethod::caliper},
         {"belac", ChordMethod::belac},
         {"xaxis", ChordMethod::x_axis},
         {"axial", ChordMethod::x_axis},
         {"radcenter", ChordMethod::rad_center},
         {"mincircle", ChordMethod::min_circle},
         {"maxdist", ChordMethod::largest},
         {"largest", ChordMethod::largest}}};
    const std::string wanted = core::in_small_letters(keyword);
    for (const auto& [name, method] : names)
        if (name == wanted) return method;
    return {};
}

std::optional<StaggerMethod> stagger_method_from(std::string_view keyword) {
    const std::string wanted = core::in_small_letters(keyword);
    if (wanted == "nosetail") return StaggerMethod::nose_tail;
    if (wanted == "caliper" || wanted == "tangent") return StaggerMethod::caliper;
    return {};
}

}  // namespace cmm::fitting
