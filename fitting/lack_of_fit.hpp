// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace cmm::fitting {

/// Where a closed curve does not follow its points: one for each of the `residuals` (in order round) that lies among 8,
/// 16 or 32 whose neighbours lie on the same side by far more than noise does: the sum of products of neighbours is
/// more than 7, 5.5, 5 of its standard deviations, the noise taken from the differences of neighbours, at least
/// `least_sigma_mm`. O(points).
std::vector<char> not_followed(std::span<const double> residuals, double least_sigma_mm);

/// How much of a narrow form a closed curve may have flattened at each of its points, by their residuals and leverages
/// in order round: the mean residual of the points around it, on either side, as far as it is more than its standard
/// deviation. Around it are seven tenths of the points that the curve averages over there (one over the leverage), at
/// least seven: where the curve follows a form it averages over few. O(points).
std::vector<double> flattened_mm(std::span<const double> residuals, std::span<const double> leverages, double sigma_mm);

}  // namespace cmm::fitting
