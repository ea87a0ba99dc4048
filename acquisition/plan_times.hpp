// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "acquisition/plan.hpp"

namespace cmm::acquisition {

/// Of an alignment by datum points, for estimates: what a part takes that stands some tenths of a millimetre beside
/// where it is expected (docs/measured.md).
inline constexpr int usual_datum_rounds = 3;

/// How long a plan takes, s: what the motions take; controllers add their time for commands.
struct PlanTimes {
    double alignment_s = 0.0;        ///< touches of the datum points, with the ways between them; 0: there are none
    std::vector<double> sections_s;  ///< one a path of the plan, without travel
    double total_s = 0.0;            ///< with travel and alignment
};

/// By scanning or by single touches.
PlanTimes plan_times(const Plan& plan, bool by_touches);

}  // namespace cmm::acquisition
