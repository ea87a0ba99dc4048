// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace cmm::fitting {

/// What one row tells of a number that changes smoothly over the rows, and its standard deviation.
struct Known {
    double value = 0.0, sigma = 1.0;
};
struct Smoothed {
    std::vector<double> value, sigma;  ///< at each z_k
    double apart = 0.0;                ///< standard deviation of what single ones are off it beyond their own
};

/// The polynomial of least squares through what is known at the z_k, each by its own standard deviation (as it is to
/// the others'), of degree 3, or up to 8 as long as what it leaves follows from one to the next (no more than one for
/// three that are known); those farther from it than six times the median of theirs are left out. Before any is left
/// out all count alike: one that is sure of a wrong place would draw the others to it.
Smoothed smoothed_over(std::span<const double> z, std::span<const std::optional<Known>> known);

/// The same, of what is sought for itself: where degree 3 is enough the bend counts as far as it is told, so that the
/// ends of what is nearly straight have no more noise than need be.
Smoothed told_over(std::span<const double> z, std::span<const std::optional<Known>> known);

}  // namespace cmm::fitting
