// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/plan.hpp"
#include "acquisition/section_result.hpp"
#include "acquisition/section_setup.hpp"
#include "acquisition/until_decided.hpp"
#include "drivers/machine.hpp"

namespace cmm::acquisition {

/// What is to be measured once more of a section that is not decided. A value.
struct AgainPass {
    /// Characteristics that more points can decide. Empty: none has limits, it is only to be measured all round.
    std::vector<std::string> because;
    std::vector<std::vector<drivers::PathPoint>> stretches;  ///< each driven by itself, counter-clockwise; all recorded
    double duration_s = 0.0;                                 ///< scans and touch-downs, estimate

    std::size_t points() const;
};

/// Plans the next pass over a judged section: only where its undecided characteristics depend on the contour (the
/// places of a profile that may lie beyond its limit, the edge of a radius, both edges of a chord or stagger, where the
/// largest circle touches), each gap between two points that are there split into as many as the guard band asks for,
/// which goes down with the square root of their number; and the places of the lap where nothing was measured, if that
/// leaves something open. Nothing: all is decided, or what is not needs more than `bound.most_density` times the
/// points, or the time is used up. A function of its arguments alone, so that a run that was cut off plans the same
/// again. `lap`: the section's path.
std::optional<AgainPass> plan_again(const SectionResult& judged, const SectionSetup& setup, const PlannedPath& lap,
                                    const UntilDecided& bound);

}  // namespace cmm::acquisition
