// SPDX-License-Identifier: Apache-2.0
#include "fitting/roughness.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "fitting/cyclic.hpp"

namespace cmm::fitting {
namespace {

constexpr double damping = 0.1;       // degrees of freedom below which a window says nothing
constexpr double longest_step = 4.0;  // of the logarithm of the scale
constexpr double least_log = -36.0;
constexpr double least_variance = 1e-16;
/// Added and taken off again: what is left is rounded to 1/1024.
constexpr double log_grid = 0x1.8p42;

/// To twelve binary digits. The updates may enlarge a difference of two runs, so that what rounding does to points that
/// are turned and moved would grow from update to update; on a grid it vanishes.
double coarse(double value) {
    constexpr std::uint64_t dropped = std::uint64_t{1} << 40;
    const auto bits = std::bit_cast<std::uint64_t>(value) + dropped / 2;
    return std::bit_cast<double>(bits & ~(dropped - 1));
}

/// For functions of many values in vector lanes.
Eigen::Map<Eigen::ArrayXd> all(std::vector<double>& values) {
    return {values.data(), static_cast<Eigen::Index>(values.size())};
}

}  // namespace

void Roughness::reset(const std::vector<double>& variance, std::size_t window, double few) {
    variance_ = variance;
    log_scale_.resize(variance.size());
    std::transform(variance.begin(), variance.end(), log_scale_.begin(), [](double v) { return std::log(v); });
    set_scale();
    held_.assign(variance.size(), 0);
    window_ = window;
    few_ = few;
    scale_known_ = false;
}

void Roughness::carry_over(const std::vector<std::size_t>& from, const std::vector<Run>& calm) {
    const std::vector<double> rough = log_scale_;
    for (const Run& run : calm)
        calm_down(run, rough);
    std::vector<double> variance(from.size()), log_scale(from.size());
    for (std::size_t k = 0; k < from.size(); ++k) {
        std::size_t old = from[k];
        while (held_[old] != 0)
            old = old > 0 ? old - 1 : variance_.size() - 1;
        variance[k] = variance_[old];
        log_scale[k] = log_scale_[old];
    }
    variance_.swap(variance);
    log_scale_.swap(log_scale);
    set_scale();
    held_.assign(from.size(), 0);
}

/// What made the run rough has told upon those that share a scale with it and upon their sharers, and where the points
/// tell little that would stay. From either end down, as long as it falls, all take what it comes to; the run itself
/// takes the calmer of the two.
void Roughness::calm_down(const Run& run, const std::vector<double>& rough) {
    const std::size_t n = rough.size();
    const auto before = [n](std::size_t k) { return cyclic(k + n - 1, n); };
    const auto behind = [n](std::size_t k) { return cyclic(k + 1, n); };
    std::size_t first = run.first, last = run.last;
    for (std::size_t step = 0; step < 2 * window_ && rough[before(first)] < rough[first]; ++step)
        first = before(first);
    for (std::size_t step = 0; step < 2 * window_ && rough[behind(last)] < rough[last]; ++step)
        last = behind(last);
    const auto take = [&](std::size_t k, double calmer) {
        log_scale_[k] = std::min(log_scale_[k], calmer);
        variance_[k] = std::min(variance_[k], coarse(std::exp(calmer)));
    };
    for (std::size_t k = first; k != run.first; k = behind(k))
        take(k, rough[first]);
    for (std::size_t k = last; k != run.last; k = before(k))
        take(k, rough[last]);
    for (std::size_t k = run.first; k <= run.last; ++k)
        take(k, std::min(rough[first], rough[last]));
}

void Roughness::adopt(const std::vector<double>& variance, double few) {
    reset(variance, window_, few);
    scale_known_ = true;
}

void Roughness::hold(std::size_t knot, double variance) {
    variance_[knot] = coarse(variance);
    held_[knot] = 1;
}

void Roughness::sum_window(std::vector<double>& values, std::size_t w) {
    const std::size_t n = values.size();
    sums_.resize(n);
    double sum = 0.0;
    for (std::size_t j = n - w; j < n + w + 1; ++j)
        sum += values[cyclic(j, n)];
    for (std::size_t k = 0; k < n; ++k) {
        sums_[k] = sum;
        sum += values[cyclic(k + w + 1, n)] - values[cyclic(k + n - w, n)];
    }
    values.swap(sums_);
}

void Roughness::update(const std::vector<double>& jump, const std::vector<double>& told) {
    if (!scale_known_) update_scale(jump, told);
    for (std::size_t k = 0; k < variance_.size(); ++k) {
        if (held_[k] != 0) continue;
        const double updated = (jump[k] * jump[k] + few_ * scale_[k]) / (told[k] + few_);
        variance_[k] = coarse(std::max(updated, least_variance));
    }
}

void Roughness::update_scale(const std::vector<double>& jump, const std::vector<double>& told) {
    const std::size_t n = variance_.size();
    pull_.resize(n);
    known_.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
        known_[k] = held_[k] != 0 ? 0.0 : told[k];
        pull_[k] = held_[k] != 0 ? 1.0 : (jump[k] * jump[k] / scale_[k] + few_) / (known_[k] + few_);
    }
    all(pull_) = all(pull_).log();
    for (std::size_t k = 0; k < n; ++k)
        pull_[k] *= known_[k] + few_;
    sum_window(pull_, window_);
    std::vector<double>& all_known = known_;
    sum_window(all_known, window_);
    for (std::size_t k = 0; k < n; ++k)
        pull_[k] = std::clamp(pull_[k] / (all_known[k] + damping), -longest_step, longest_step);
    const std::size_t half = window_ / 2;
    sum_window(pull_, half);
    for (std::size_t k = 0; k < n; ++k) {
        if (held_[k] != 0) continue;
        const double log_scale = std::max(log_scale_[k] + pull_[k] / static_cast<double>(2 * half + 1), least_log);
        log_scale_[k] = (log_scale + log_grid) - log_grid;
    }
    set_scale();
}

void Roughness::set_scale() {
    scale_.resize(log_scale_.size());
    all(scale_) = all(log_scale_).exp();
}

}  // namespace cmm::fitting
