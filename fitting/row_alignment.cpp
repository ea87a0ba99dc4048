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

constexpr double joint_share = 0.6;         // of the rows that know a joint
constexpr double same_way_share = 0.8;      // of those: the curvature rises there, or it falls
constexpr double most_unlike = 1.25;        // of its places: those of joints that all rows have are 0.90 at most
constexpr std::size_t rows_that_judge = 6;  // of a form over z that fewer do not tell
constexpr double step_range = 3.0;          // of a joint's step over the rows, over the usual one
constexpr double least_told_mm = 3e-4;      // of a joint's place

/// Whether a side begins at a feature.
constexpr bool is_side(std::size_t feature) {
    return feature == RowFeatures::le_end || feature == RowFeatures::te_end;
}

/// Of a feature among the knots: two more on each side before it.
constexpr std::size_t knot_of(std::size_t feature) {
    return feature + (feature > RowFeatures::le_end ? 2 : 0) + (feature > RowFeatures::te_end ? 2 : 0);
}

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

/// The median.
double usual(std::vector<double> values) {
    return nth_smallest(values, values.size() / 2);
}

double usual_off(std::span<const std::optional<Known>> known, const Smoothed& smooth) {
    std::vector<double> off;
    for (std::size_t k = 0; k < known.size(); ++k)
        if (known[k]) off.push_back(std::abs(known[k]->value - smooth.value[k]));
    return usual(std::move(off));
}

/// Whether a step up is one on most rows that know the joint, or a step down.
bool same_way(std::span<const RowFeatures> rows, RowFeatures::Feature end) {
    double up = 0.0, down = 0.0;
    for (const RowFeatures& row : rows)
        if (row.joints[end]) (row.joints[end]->step > 0.0 ? up : down) += 1.0;
    return std::max(up, down) >= same_way_share * (up + down);
}

/// Where most rows know a joint, and agree on its place, by what each can tell and by how evenly the edges end
/// (`ends_off_mm`). Each row of a real part may know one that is nowhere else.
std::optional<Smoothed> common_joint(std::span<const double> z, std::span<const std::optional<Known>> joints,
                                     double ends_off_mm) {
    std::vector<double> sigma;
    for (const auto& joint : joints)
        if (joint) sigma.push_back(joint->sigma);
    if (!(static_cast<double>(sigma.size()) > joint_share * static_cast<double>(z.size()))) return std::nullopt;
    Smoothed smooth = smoothed_over(z, joints);
    if (sigma.size() >= rows_that_judge &&
        usual_off(joints, smooth) > most_unlike * std::hypot(usual(sigma), ends_off_mm))
        return std::nullopt;
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
        const bool before_le = end == RowFeatures::le_begin;
        const auto origin = [&](std::size_t k) { return before_le ? rows[k].length_mm : ahead[nose][k]; };
        std::vector<std::optional<Known>> ends(n), at_joints(n);
        for (std::size_t k = 0; k < n; ++k) {
            ends[k] = Known{ahead[end][k] - origin(k), 1.0};
            if (const auto& joint = rows[k].joints[end])
                at_joints[k] = Known{from_nose(k, joint->s_mm) - origin(k), std::max(joint->sigma_mm, least_told_mm)};
        }
        Smoothed smooth = smoothed_over(z, ends);
        if (auto joint = common_joint(z, at_joints, usual_off(ends, smooth)); joint && same_way(rows, end)) {
            at_joint[end] = true;
            smooth = std::move(*joint);
        }
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
    knot_u_ = with_quarters(u_);
    for (std::size_t k = 0; k < n; ++k) {
        AtFeatures s;
        for (std::size_t j = 0; j < count; ++j)
            s[j] = rows[k].s_mm[RowFeatures::le_nose] + ahead[j][k];
        s[count] = s[0] + rows[k].length_mm;
        maps_.push_back(map_of(with_quarters(s)));
    }
}

/// At the features, and a quarter from each end of a side: an edge that is longer on one row would otherwise move the
/// places all along it.
RowAlignment::AtKnots RowAlignment::with_quarters(const AtFeatures& at) {
    AtKnots values;
    for (std::size_t j = 0; j <= count; ++j) {
        values[knot_of(j)] = at[j];
        if (!is_side(j)) continue;
        values[knot_of(j) + 1] = 0.75 * at[j] + 0.25 * at[j + 1];
        values[knot_of(j) + 2] = 0.25 * at[j] + 0.75 * at[j + 1];
    }
    return values;
}

RowAlignment::Map RowAlignment::map_of(const AtKnots& s) const {
    Map map{s, {}};
    constexpr std::size_t spans = knots - 1;
    std::array<double, spans> secant;
    for (std::size_t j = 0; j < spans; ++j)
        secant[j] = (map.s[j + 1] - map.s[j]) / (knot_u_[j + 1] - knot_u_[j]);
    for (std::size_t j = 0; j < knots; ++j) {
        const double left = secant[(j + spans - 1) % spans], right = secant[j % spans];
        map.slope[j] = left * right > 0.0 ? 2.0 * left * right / (left + right) : 0.0;
    }
    return map;
}

std::vector<RowAlignment::CommonJoint> RowAlignment::joints_on(std::size_t row) const {
    std::vector<CommonJoint> joints;
    for (std::size_t j = 0; j < count; ++j)
        if (!joint_sigma_mm_[j].empty())
            joints.push_back({maps_[row].s[knot_of(j)], joint_sigma_mm_[j][row], joint_step_[j][row]});
    return joints;
}

double RowAlignment::arc_length(std::size_t row, double u) const {
    const Map& map = maps_[row];
    const auto above = std::upper_bound(knot_u_.begin() + 1, knot_u_.end() - 1, u);
    const auto j = static_cast<std::size_t>(above - knot_u_.begin()) - 1;
    const double h = knot_u_[j + 1] - knot_u_[j], w = (u - knot_u_[j]) / h;
    const double a = map.s[j], b = map.s[j + 1], p = h * map.slope[j], q = h * map.slope[j + 1];
    return a + w * (p + w * (3.0 * (b - a) - 2.0 * p - q + w * (2.0 * (a - b) + p + q)));
}

}  // namespace cmm::fitting
