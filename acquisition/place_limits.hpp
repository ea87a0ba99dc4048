// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace cmm::acquisition {

/// Lowest and highest deviation that conform at a place, with their signs.
struct PointTolerance {
    double below_mm = 0.0, above_mm = 0.0;
};

}  // namespace cmm::acquisition
