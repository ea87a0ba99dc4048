// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/characteristic_spec.hpp"
#include "acquisition/nom_file.hpp"
#include "acquisition/tol_file.hpp"
#include "core/error.hpp"

namespace cmm::acquisition {

/// The characteristics that a tolerance file asks for, of the sections measured at `heights_mm`; sections go by the
/// names that `nom` gives to heights (nullptr: no section has a name). Those of one requirement are one with a list of
/// sections. Errors: input_invalid with file:line:column (a section that `nom` does not have, an edge thickness without
/// its distance).
core::Result<std::vector<CharacteristicSpec>> characteristics_of(const TolFile& tol, const NomFile* nom,
                                                                 std::span<const double> heights_mm);

}  // namespace cmm::acquisition
