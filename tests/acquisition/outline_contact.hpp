// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "acquisition/clearance.hpp"
#include "drivers/machine.hpp"
#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {

/// Where a ball of 1 mm touches the blade of session_fixture.hpp, for FakeMachine::contact.
struct OutlineContact {
    explicit OutlineContact(const SessionPart& job)
        : outlines{job.nominal->cut(20.0)->points, job.nominal->cut(40.0)->points} {}

    /// Between ball and part, mm.
    double gap_mm(const Eigen::Vector3d& centre) const {
        return distance_to_outline(centre.head<2>(), outlines.at(centre.z() < 30.0 ? 0 : 1)) - 1.0;
    }
    /// Along the normal until the ball touches, at most the search distance.
    std::optional<Eigen::Vector3d> operator()(const drivers::PathPoint& point) const {
        const bool free = gap_mm(point.centre_mm) > 0.0;
        const Eigen::Vector3d way = free ? Eigen::Vector3d(-point.normal) : point.normal;
        for (double gone = 0.0; gone <= 1.5;) {
            const double room = gap_mm(point.centre_mm + gone * way);
            if (free ? room < 1e-5 : room > -1e-5) return Eigen::Vector3d(point.centre_mm + gone * way);
            gone += std::max(std::abs(room), 1e-6);
        }
        return std::nullopt;
    }

    std::array<std::vector<Eigen::Vector2d>, 2> outlines;
};

}  // namespace cmm::acquisition
