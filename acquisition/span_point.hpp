// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "acquisition/characteristic_spec.hpp"
#include "acquisition/section_result.hpp"
#include "fitting/nominal.hpp"
#include "fitting/plane_motion.hpp"

namespace cmm::acquisition {

/// The deviation at the place of a generatrix: a share of the length of one side of the nominal, from the LE's end to
/// the TE's. `alignment` leads from the nominal to the measured section. None where the measured contour does not pass
/// there.
std::optional<SpanPoint> span_point(const fitting::SectionFit& fit, const fitting::NominalSection& nominal,
                                    const Alignment& alignment, const CharacteristicSpec& spec);

}  // namespace cmm::acquisition
