// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace cmm::acquisition {

/// Where closed profiles of one number of points begin, so that point k of one can be joined to the same place of the
/// next (docs/part-file.md, "Loft").
struct ProfileStarts {
    /// Of each profile the point opposite the first point of the first one; 0 everywhere where the profiles are points
    /// of one drawing.
    std::vector<std::size_t> first;
    /// Whether its points lie opposite points of its neighbour, not between two of them.
    bool points_agree = true;

    bool all_at_first() const noexcept;
};

/// Profiles that run the same way round, seen along the span, ascending. For each of them and the one below: the start
/// from which both are most nearly similar figures, turned by less than a right angle. Pure.
ProfileStarts profile_starts(const std::vector<std::vector<Eigen::Vector2d>>& profiles);

/// Of two profiles with as many points, evenly along them: the share of its length, -0.5 to 0.5, by which `above` has
/// to begin later for its points to lie opposite those of `below`.
double share_opposite(const std::vector<Eigen::Vector2d>& below, const std::vector<Eigen::Vector2d>& above);

}  // namespace cmm::acquisition
