// SPDX-License-Identifier: Apache-2.0
#include "acquisition/listed_characteristic.hpp"

#include <algorithm>

#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

std::string at_height(const std::string& name, double z_mm) {
    return name + " z " + core::fixed(z_mm, 3);
}

}  // namespace

std::vector<ListedCharacteristic> all_characteristics(const PartResult& part) {
    std::vector<ListedCharacteristic> all;
    for (const auto& section : part.sections)
        for (const auto& one : section.characteristics)
            all.push_back({at_height(one.name, section.z_mm), &one});
    for (const auto& [one, index] : part.characteristics) {
        const auto found =
            std::find_if(part.sections.begin(), part.sections.end(),
                         [&, index = index](const SectionResult& section) { return index == section.index; });
        all.push_back({found == part.sections.end() ? one.name : at_height(one.name, found->z_mm), &one});
    }
    return all;
}

}  // namespace cmm::acquisition
