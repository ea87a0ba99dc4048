// SPDX-License-Identifier: Apache-2.0
#include "fitting/row_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "fitting/over_rows.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr double joint_share = 0.6;     // of the rows that know a joint
constexpr double step_range = 3.0;      // of a joint's step over the rows, over the usual one
constexpr double least_told_mm = 3e-4;  // of a joint's place

/// Steps of the curvature at a joint, smoothed over the rows. A row whose points are off there tells any step.
std::vector<double> common_steps(std::span<const RowFeatures> rows, RowFeatures::Feature end,
                                 std::span<const double> z) {
    std::vector<double> steps;
    for (const RowFeatures& row : rows)
        if (row.joints[end]) steps.push_back(row.joints[end]->step);
    const double usual = nth_smallest(steps, steps.size() / 2);
    const auto [low, high] = std::minmax({usual / step_range, usual * step_range});
    std::vector<std::optional<Known>> known(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k)
        if (rows[k].joints[end]) known[k] = Known{std::clamp(rows[k].joints[end]->step, low, high)};
    auto smooth = smoothed_over(z, known).value;
    for (double& step : smooth)
        step = std::clamp(step, low, high);
    return smooth;
}

}  // namespace

RowAlignment::RowAlignment(std::span<const RowFeatures> rows) {
    const std::size_t n = rows.size();
    std::vector<double> z(n);
    std::array<std::vector<double>, count> ahead;  // of the LE nose
    const auto from_nose = [&](std::size_t k, double s) {
        const double d = s - rows[k].s_mm[RowFeatures::le_nose], l = rows[k].length_mm;
        return d - std::floor(d / l) * l;
    };
    for (std::size_t k = 0; k < n; ++k) {
        z[k] = rows[k].z_mm;
        for (std::size_t j = 0; j < count; ++j)
            ahead[j].push_back(from_nose(k, rows[k].s_mm[j]));
    }
    // The ends of the edges, as distances from their noses.
    std::array<bool, count> at_joint{};
    for (const auto& [end, nose] : {std::pair{RowFeatures::le_end, RowFeatures::le_nose},
                                    {RowFeatures::te_begin, RowFeatures::te_nose},
                                    {RowFeatures::te_end, RowFeatures::te_nose},
                                    {RowFeatures::le_begin, RowFeatures::le_nose}}) {
        std::size_t known = 0;
        for (const RowFeatures& row : rows)
            known += static_cast<std::size_t>(row.joints[end].has_value());
        at_joint[end] = static_cast<double>(known) > joint_share * static_cast<double>(n);
        const bool before_le = end == RowFeatures::le_begin;
        const auto origin = [&](std::size_t k) { return before_le ? rows[k].length_mm : ahead[nose][k]; };
        std::vector<std::optional<Known>> apart(n);
        for (std::size_t k = 0; k < n; ++k) {
            const auto& joint = rows[k].joints[end];
            if (!at_joint[end])
                apart[k] = Known{ahead[end][k] - origin(k), 1.0};
            else if (joint)
                apart[k] = Known{from_nose(k, joint->s_mm) - origin(k), std::max(joint->sigma_mm, least_told_mm)};
        }
        const auto smooth = smoothed_over(z, apart);
        for (std::size_t k = 0; k < n; ++k)
            ahead[end][k] = origin(k) + smooth.value[k];
        if (!at_joint[end]) continue;
        for (const double sigma : smooth.sigma)
            joint_sigma_mm_[end].push_back(std::hypot(sigma, smooth.apart));
        joint_step_[end] = common_steps(rows, end, z);
    }
    // A row on which the common ends would not follow each other keeps its own, which do.
    for (std::size_t k = 0; k < n; ++k) {
        const auto follow = [&](std::size_t j) {
            return ahead[j][k] < (j + 1 < count ? ahead[j + 1][k] : rows[k].length_mm);
        };
        bool all = true;
        for (std::size_t j = 0; j < count; ++j)
            all = all && follow(j);
        for (std::size_t j = 0; j < count && !all; ++j)
            ahead[j][k] = from_nose(k, rows[k].s_mm[j]);
    }
    for (std::size_t k = 0; k < n; ++k)
        period_ += rows[k].length_mm / static_cast<double>(n);
    for (std::size_t j = 0; j < count; ++j)
        for (std::size_t k = 0; k < n; ++k)
            u_[j] += ahead[j][k] / rows[k].length_mm * period_ / static_cast<double>(n);
    u_[count] = period_;
    for (std::size_t j = 0; j < count; ++j)
        if (at_joint[j]) joints_.push_back(u_[j]);
    for (std::size_t k = 0; k < n; ++k) {
        Map map;
        for (std::size_t j = 0; j < count; ++j)
            map.s[j] = ahead[j][k];
        map.s[count] = rows[k].length_mm;
        std::array<double, count> secant;
        for (std::size_t j = 0; j < count; ++j)
            secant[j] = (map.s[j + 1] - map.s[j]) / (u_[j + 1] - u_[j]);
        for (std::size_t j = 0; j <= count; ++j) {
            const double left = secant[(j + count - 1) % count], right = secant[j % count];
            map.slope[j] = left * right > 0.0 ? 2.0 * left * right / (left + right) : 0.0;
        }
        for (double& s : map.s)
            s += rows[k].s_mm[RowFeatures::le_nose];
        maps_.push_back(map);
    }
}

std::vector<RowAlignment::CommonJoint> RowAlignment::joints_on(std::size_t row) const {
    std::vector<CommonJoint> joints;
    for (std::size_t j = 0; j < count; ++j)
        if (!joint_sigma_mm_[j].empty())
            joints.push_back({maps_[row].s[j], joint_sigma_mm_[j][row], joint_step_[j][row]});
    return joints;
}

double RowAlignment::arc_length(std::size_t row, double u) const {
    const Map& map = maps_[row];
    const auto above = std::upper_bound(u_.begin() + 1, u_.end() - 1, u);
    const auto j = static_cast<std::size_t>(above - u_.begin()) - 1;
    const double h = u_[j + 1] - u_[j], w = (u - u_[j]) / h;
    const double a = map.s[j], b = map.s[j + 1], p = h * map.slope[j], q = h * map.slope[j + 1];
    return a + w * (p + w * (3.0 * (b - a) - 2.0 * p - q + w * (2.0 * (a - b) + p + q)));
}

}  // namespace cmm::fitting
