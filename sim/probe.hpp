// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace cmm::sim {

/// How a probe errs. Shares are of recorded points, 0 ... 1.
struct ProbeErrorModel {
    std::uint64_t seed = 1;
    double noise_mm = 0.0;            ///< standard deviation along the normal
    double bad_points_share = 0.0;    ///< over the whole path
    double edge_points_share = 0.25;  ///< of the path's points whose edge-ness exceeds 0.5: set it from the path
    double bad_at_edges_share = 0.7;  ///< of the bad points
    double outward_share = 0.75;      ///< of the bad points: dirt lifts the ball; the rest sinks
    double smallest_bad_mm = 0.020;
    double largest_bad_mm = 0.400;
};

/// What is added to a contact along its normal, out of the material positive.
struct ProbeError {
    double noise_mm = 0.0;
    double bad_mm = 0.0;  ///< 0: a good point
};

/// The error of a recorded point: a function of its arguments alone, so that a run repeats exactly whatever its timing
/// and interruptions. Bad points come as singles and in runs of two or three with one sign, sizes log-uniform.
ProbeError probe_error(const ProbeErrorModel& model, std::uint16_t path, std::uint32_t index, double edge_ness);

}  // namespace cmm::sim
