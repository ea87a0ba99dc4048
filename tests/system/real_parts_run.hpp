// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "tests/system/real_parts.hpp"

namespace cmm::test {

/// Largest errors of the contour by kind of place. Where the ball touches the part at the contour point: distance of
/// the point to the exact cut. Where it touches elsewhere (it rests on both sides of a hollow, and the contour shows
/// the ball): how far a ball behind the contour point would be from touching the part, in three dimensions.
struct ContourError {
    double worst_mm = 0.0;          ///< where the surface leans less than 8 degrees and no hollow is near
    double worst_leaning_mm = 0.0;  ///< where it leans more
    double worst_beside_mm = 0.0;   ///< less than 1.5 mm from a hollow's bridge, leaning less than 8 degrees
    double worst_bridge_mm = 0.0;   ///< on the bridge
    std::size_t judged = 0, leaning = 0, beside = 0, bridged = 0;
};

struct Rejections {
    std::size_t good = 0, good_lost = 0, good_lost_beside = 0, bad = 0, bad_missed = 0;
};

/// A real part, scanned by the product over Modbus TCP and compared with the simulator's own geometry (the exact cut)
/// and its own log of the errors that it injected.
struct RealPartRun {
    std::string failure;  ///< empty: the scan ran to its end and all files are there
    std::size_t sections = 0, closed = 0, four_zones = 0;
    ContourError contour;
    Rejections points;
    std::string text() const;
};
RealPartRun run_real_part(const RealPart& part, bool unknown, int seed);

}  // namespace cmm::test
