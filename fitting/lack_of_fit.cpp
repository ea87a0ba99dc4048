// SPDX-License-Identifier: Apache-2.0
#include "fitting/lack_of_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

/// The largest of some 1 000 such sums of noise is below this in 99.5 % of the cases (products have long tails).
struct SidedRun {
    std::size_t points;
    double most_sigmas;
};
constexpr SidedRun sided_runs[] = {{8, 7.0}, {16, 5.5}, {32, 5.0}};

}  // namespace

std::vector<char> not_followed(std::span<const double> residuals, double least_sigma_mm) {
    const std::size_t n = residuals.size();
    const auto round = [n](std::size_t i) { return i < n ? i : i - n; };
    std::vector<char> found(n, 0);
    std::vector<double> products(n), steps(n);
    for (std::size_t i = 0; i < n; ++i) {
        const double next = residuals[round(i + 1)];
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
                    found[round(i + marked)] = 1;
            if (marked > 0) --marked;
            sum += products[round(i + window)] - products[i];
        }
    }
    return found;
}

}  // namespace cmm::fitting
