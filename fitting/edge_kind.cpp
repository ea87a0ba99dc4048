// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_kind.hpp"

#include <array>
#include <utility>

namespace cmm::fitting {
namespace {

constexpr std::array<std::pair<EdgeModel, std::string_view>, 5> models{{{EdgeModel::free, "free"},
                                                                        {EdgeModel::arc, "arc"},
                                                                        {EdgeModel::ellipse, "ellipse"},
                                                                        {EdgeModel::double_arc, "double_arc"},
                                                                        {EdgeModel::parabola, "parabola"}}};

}  // namespace

std::string_view to_string(EdgeModel model) noexcept {
    for (const auto& [value, name] : models)
        if (value == model) return name;
    return "";
}

std::optional<EdgeModel> edge_model_from(std::string_view name) noexcept {
    for (const auto& [value, known] : models)
        if (known == name) return value;
    return {};
}

std::string_view to_string(EdgeForm form) noexcept {
    switch (form) {
        case EdgeForm::round:
            return "round";
        case EdgeForm::blunt:
            return "blunt";
        case EdgeForm::square:
            return "square";
        case EdgeForm::partial:
            return "partial";
    }
    return "";
}

}  // namespace cmm::fitting
