// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "fitting/surface.hpp"
#include "fitting/surface_rows.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::fitting {

struct MeasuredRows {
    std::vector<Vec3> points;
    std::vector<SurfaceRow> rows;
};

/// Rows of 340 to 460 points on the part itself, 1 um noise along the normal. `change` may change the points of a row.
inline MeasuredRows measured_rows(const families::TwistedBlade& blade, std::size_t count,
                                  const std::function<void(std::size_t row, std::vector<Vec2>& points)>& change = {}) {
    MeasuredRows result;
    std::optional<Vec2> le, te;
    for (std::size_t k = 0; k < count; ++k) {
        const double z = 2 + (blade.height() - 4) * double(k) / double(count - 1);
        families::ScanOptions scanning;
        scanning.ball_mm = 0.0;
        scanning.bad_share = 0.0;
        scanning.points = 340 + k * 37 % 121;
        scanning.seed = 1 + k;
        const auto row = families::scan_rows(blade, 1, z, z, scanning).rows[0];
        std::vector<Vec2> plane;
        for (const Vec3& p : row)
            plane.push_back(p.head<2>());
        if (change) change(k, plane);
        if (!le) {
            le = blade.outline(z).le().nose;
            te = blade.outline(z).te().nose;
        }
        auto made = SurfaceRow::make(smooth_closed(plane).value(), z, 0.0, le, te);
        EXPECT_TRUE(made);
        le = made->le();
        te = made->te();
        result.rows.push_back(std::move(*made));
        result.points.insert(result.points.end(), row.begin(), row.end());
    }
    return result;
}

}  // namespace cmm::fitting
