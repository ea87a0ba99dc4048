// SPDX-License-Identifier: Apache-2.0
#include "fitting/statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace cmm::fitting {
namespace {

constexpr double normal_975 = 1.959963984540054;
constexpr double normal_999 = 3.090232306167813;

/// Two values of a small sample between which the nth is likely to be.
std::pair<double, double> likely_bracket(std::span<const double> values, std::size_t nth) {
    constexpr std::size_t sampled = 64, margin = 10;
    std::array<double, sampled> sample;
    for (std::size_t k = 0; k < sampled; ++k)
        sample[k] = values[k * values.size() / sampled];
    std::sort(sample.begin(), sample.end());
    const std::size_t middle = nth * sampled / values.size();
    return {sample[middle > margin ? middle - margin : 0], sample[std::min(middle + margin, sampled - 1)]};
}

/// The deviate that a standard normal number exceeds in magnitude with probability `tails` (below 1).
double deviate_of_tails(double tails) {
    double k = normal_975;
    // Newton's method on the logarithm of the tails, which is nearly a parabola.
    for (int step = 0; step < 20; ++step) {
        const double here = std::erfc(k / std::numbers::sqrt2);
        const double slope = -std::sqrt(2.0 / std::numbers::pi) * std::exp(-0.5 * k * k) / here;
        const double move = std::log(tails / here) / slope;
        k += move;
        if (std::abs(move) < 1e-12) break;
    }
    return k;
}

}  // namespace

double nth_smallest(std::span<double> values, std::size_t nth) {
    constexpr std::size_t many = 256;
    if (values.size() >= many) {
        const auto [low, high] = likely_bracket(values, nth);
        std::size_t below = 0, up_to = 0;
        for (const double value : values) {
            below += value < low;
            up_to += value <= high;
        }
        if (nth >= below && nth < up_to) {
            std::size_t kept = 0;
            for (const double value : values) {
                values[kept] = value;
                kept += static_cast<unsigned>(value >= low) & static_cast<unsigned>(value <= high);
            }
            values = values.first(kept);
            nth -= below;
        }
    }
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(nth);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

double coverage_95(double freedom) {
    constexpr double p = 0.05;  // in both tails
    const double n = freedom;
    if (!(n >= 1.0)) return std::numeric_limits<double>::infinity();
    if (n > 1e9) return normal_975;
    if (n == 1.0) return std::cos(0.5 * std::numbers::pi * p) / std::sin(0.5 * std::numbers::pi * p);
    if (n == 2.0) return std::sqrt(2.0 / (p * (2.0 - p)) - 2.0);
    const double a = 1.0 / (n - 0.5), b = 48.0 / (a * a);
    double c = ((20700.0 * a / b - 98.0) * a - 16.0) * a + 96.36;
    const double d = ((94.5 / (b + c) - 3.0) / b + 1.0) * std::sqrt(a * std::numbers::pi / 2.0) * n;
    double y = std::pow(d * p, 2.0 / n);
    if (y <= 0.05 + a) {
        y = ((1.0 / (((n + 6.0) / (n * y) - 0.089 * d - 0.822) * (n + 2.0) * 3.0) + 0.5 / (n + 4.0)) * y - 1.0) *
                (n + 1.0) / (n + 2.0) +
            1.0 / y;
        return std::sqrt(n * y);
    }
    const double x = -normal_975;
    if (n < 5.0) c += 0.3 * (n - 4.5) * (x + 0.6);
    c += (((0.05 * d * x - 5.0) * x - 7.0) * x - 2.0) * x + b;
    y = (((((0.4 * x * x + 6.3) * x * x + 36.0) * x * x + 94.5) / c - x * x - 3.0) / b + 1.0) * x;
    return std::sqrt(n * std::expm1(a * y * y));
}

double upper_deviate(double risk) {
    return deviate_of_tails(2.0 * risk);
}

double upper_deviate_of_largest(double risk, double count) {
    return deviate_of_tails(-2.0 * std::expm1(std::log1p(-risk) / count));
}

double coverage_95_of_largest(double count) {
    return deviate_of_tails(-std::expm1(std::log(0.95) / count));
}

double chi_square_limit(double freedom, double z) {
    const double a = 2.0 / (9.0 * freedom), root = 1.0 - a + z * std::sqrt(a);
    return freedom * root * root * root;
}

double chi_square_limit_999(std::size_t freedom) {
    static const auto limits = [] {
        std::array<double, 32> out{};
        for (std::size_t n = 1; n < out.size(); ++n)
            out[n] = chi_square_limit(static_cast<double>(n), normal_999);
        return out;
    }();
    return limits[freedom];
}

Noise combined_noise(double squares, double freedom, const Noise& known) {
    const Noise own{std::sqrt(squares / freedom), freedom};
    if (!(known.freedom > 0.0) || !(known.sigma_mm > 0.0)) return own;
    const double variance = known.sigma_mm * known.sigma_mm;
    // Paulson 1942: a ratio of variances is a ratio of Wilson and Hilferty's normal cube roots.
    const double a = 2.0 / (9.0 * freedom), b = 2.0 / (9.0 * known.freedom);
    const double root = std::cbrt(squares / freedom / variance);
    if ((1.0 - b) * root - (1.0 - a) > normal_999 * std::sqrt(b * root * root + a)) return own;
    if (std::isinf(known.freedom)) return known;
    const double both = known.freedom + freedom;
    return {std::sqrt((known.freedom * variance + squares) / both), both};
}

}  // namespace cmm::fitting
