// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "acquisition/evaluation.hpp"

namespace cmm::acquisition {

/// How many of the points that were used lie outside the tolerance zone, in the zone of `spec` or in all of them. A
/// point's deviation is that of the contour at its foot and its own distance from the contour, so its error is the
/// noise of a point beside that of contour and alignment; no filter takes part. All points of the zone share the risk
/// of the rule (Sidak 1967): value less guard_reject are out for certain, value plus guard_accept may be.
/// Not evaluable without deviations, and where no tolerance zone is known.
Characteristic points_out(const CharacteristicSpec& spec, const SectionResult& section,
                          const EvaluationOptions& options);

}  // namespace cmm::acquisition
