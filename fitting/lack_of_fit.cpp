// SPDX-License-Identifier: Apache-2.0
#include "fitting/lack_of_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fitting/cyclic.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

/// The largest of some 1 000 such sums of noise is below this in 99.5 % of the cases (products have long tails).
struct SidedRun {
    std::size_t points;
    double most_sigmas;
};
constexpr SidedRun sided_runs[] = {{8, 7.0}, {16, 5.5}, {32, 5.0}};

constexpr double share_around = 0.7;  // of the points that a curve averages over
constexpr std::size_t least_to_either_side = 3;

}  // namespace

std::vector<char> not_followed(std::span<const double> residuals, double least_sigma_mm) {
    const std::size_t n = residuals.size();
    std::vector<char> found(n, 0);
    std::vector<double> products(n), steps(n);
    for (std::size_t i = 0; i < n; ++i) {
        const double next = residuals[cyclic(i + 1, n)];
        products[i] = residuals[i] * next;
        steps[i] = std::abs(next - residuals[i]);
    }
    const double sigma = std::max(nth_smallest(steps, n / 2) / (0.6745 * std::numbers::sqrt2), least_sigma_mm);
    for (const auto& [window, most_sigmas] : sided_runs) {
        if (2 * window > n) break;
        const double most = most_sigmas * sigma * sigma * std::sqrt(static_cast<double>(window));
        double sum = 0.0;
        for (std::size_t i = 0; i < window; ++i)
            sum += products[i];
        std::size_t marked = 0;  // points behind the place that the window begins at
        for (std::size_t i = 0; i < n; ++i) {
            if (sum > most)
                for (; marked < window; ++marked)
                    found[cyclic(i + marked, n)] = 1;
            if (marked > 0) --marked;
            sum += products[cyclic(i + window, n)] - products[i];
        }
    }
    return found;
}

std::vector<double> flattened_mm(std::span<const double> residuals, std::span<const double> leverages,
                                 double sigma_mm) {
    const std::size_t n = residuals.size();
    std::vector<double> found(n, 0.0), sums(n + 1, 0.0);
    if (n < 2 * least_to_either_side + 1) return found;
    for (std::size_t i = 0; i < n; ++i)
        sums[i + 1] = sums[i] + residuals[i];
    const auto sum = [&](std::size_t first, std::size_t end) { return sums[end] - sums[first]; };
    const std::size_t most = (n - 1) / 2;
    for (std::size_t i = 0; i < n; ++i) {
        const double around = share_around / std::max(leverages[i], share_around / static_cast<double>(n));
        const std::size_t reach = std::clamp(static_cast<std::size_t>(0.5 * around), least_to_either_side, most);
        const auto count = static_cast<double>(2 * reach + 1);
        const double all = i < reach            ? sum(0, i + reach + 1) + sum(n + i - reach, n)
                           : i + reach + 1 <= n ? sum(i - reach, i + reach + 1)
                                                : sum(i - reach, n) + sum(0, i + reach + 1 - n);
        found[i] = std::max(std::abs(all) - sigma_mm * std::sqrt(count), 0.0) / count;
    }
    return found;
}

}  // namespace cmm::fitting
