// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace cmm::fitting {

/// The value that would stand at `nth` (below their number) if the values were sorted; they are reordered, and some may
/// get lost. As std::nth_element, but without its mispredicted branches where the values are many.
double nth_smallest(std::span<double> values, std::size_t nth);

/// A standard deviation of measured points and what it rests on.
struct Noise {
    double sigma_mm = 0.0;
    double freedom = 0.0;  ///< degrees of freedom behind it; 0: nothing is known, infinity: known exactly
};

/// The factor that makes a 95 % two-sided interval of a standard uncertainty with so many degrees of freedom (1 or
/// more, infinity allowed): Student's t by Hill 1970, CACM algorithm 396.
double coverage_95(double freedom);

/// What the largest magnitude of `count` (1 or more) independent standard normal numbers stays below with probability
/// 0.95 (Sidak 1967): 1.96 for one, 3.16 for 32.
double coverage_95_of_largest(double count);

/// The standard normal deviate that is exceeded with probability `risk` (below 0.5).
double upper_deviate(double risk);

/// What the largest of `count` (1 or more) independent standard normal numbers exceeds with probability `risk`
/// (Sidak 1967).
double upper_deviate_of_largest(double risk, double count);

/// The value that a chi-square with `freedom` degrees of freedom exceeds with the probability of the standard normal
/// deviate `z`: Wilson and Hilferty 1931, within 1 % at 0.1 % from 10 degrees of freedom on.
double chi_square_limit(double freedom, double z);

/// Likewise with the probability 0.001, from a table; up to 31 degrees of freedom.
double chi_square_limit_999(std::size_t freedom);

/// The noise of a fit whose orthogonal residuals have the sum of squares `squares` over `freedom` degrees of freedom,
/// given what was known before: both estimates pooled, or the residuals alone where they are larger than the earlier
/// knowledge allows with probability 0.999 (then they hold form error, too).
Noise combined_noise(double squares, double freedom, const Noise& known);

}  // namespace cmm::fitting
