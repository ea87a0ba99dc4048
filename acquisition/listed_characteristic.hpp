// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "acquisition/section_result.hpp"

namespace cmm::acquisition {

/// A characteristic as files name it that know no sections. `number` points into the part.
struct ListedCharacteristic {
    std::string name;  ///< "chord z 20.000", of the part as a whole "lean_x"
    const Characteristic* number = nullptr;
};

/// All of a part: section by section in the order of measurement, then those that need several sections.
std::vector<ListedCharacteristic> all_characteristics(const PartResult& part);

}  // namespace cmm::acquisition
