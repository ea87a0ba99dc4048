// SPDX-License-Identifier: Apache-2.0
#include "fitting/joint_knots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmm::fitting {
namespace {

constexpr double knot_share = 0.02;  // of a span: how near they are
constexpr double place_grid_mm = 1e-3;
constexpr double least_told = 1e-3;
constexpr std::ptrdiff_t clear_spans = 3;  // from a joint to the next

/// A joint ahead of its knots turns the tangent by its step a millimetre: so much is the scaled change of the
/// curvature's slope at the middle knot.
double turn_per_mm(double step, double apart) {
    return 2.0 * step / (apart * apart * std::sqrt(apart));
}

}  // namespace

double on_grid(double t) {
    return std::round(t / place_grid_mm) * place_grid_mm;
}

bool have_room(double t, double next_t, std::span<const double> breaks) {
    const auto first = std::lower_bound(breaks.begin(), breaks.end(), t);
    return std::lower_bound(breaks.begin(), breaks.end(), next_t) - first >= clear_spans;
}

std::vector<double> with_joint_knots(std::span<const double> breaks, std::span<const double> places,
                                     std::vector<KnotCluster>& knots) {
    return breaks_with_joints(breaks, places, knots_of_joint, knot_share, knots);
}

std::vector<double> without_joint_knots(const std::vector<double>& breaks, std::span<const KnotCluster> joints) {
    std::vector<double> plain;
    std::size_t next = 0;
    const auto copy_to = [&](std::size_t end) {
        plain.insert(plain.end(), breaks.begin() + static_cast<std::ptrdiff_t>(next),
                     breaks.begin() + static_cast<std::ptrdiff_t>(end));
    };
    for (const KnotCluster& joint : joints) {
        copy_to(joint.first);
        next = joint.first + knots_of_joint;
    }
    copy_to(breaks.size());
    return plain;
}

void free_joint(SmoothingSystem& system, const KnotCluster& knots, double step, double sigma_mm, double ahead_mm) {
    const auto& [first, apart] = knots;
    const double turn = turn_per_mm(step, apart), any = std::numeric_limits<double>::infinity();
    system.roughness().hold(first - 1, any);
    system.roughness().hold(first, turn * turn * sigma_mm * sigma_mm);
    system.roughness().hold(first + 1, any);
    system.expect_jump(first, turn * ahead_mm);
}

SeenJoint seen_at(const PiecewiseCubic& curve, double t, double apart) {
    const double before = curve.jet(t - apart).curvature(), behind = curve.jet(t + apart).curvature();
    const double turn = apart * (curve.jet(t).curvature() - 0.5 * (before + behind));
    return {behind - before, -turn / (behind - before)};
}

double off_expected_mm(const SmoothingSystem& system, const KnotCluster& knots, double step) {
    return system.moved(knots.first) / turn_per_mm(step, knots.apart);
}

void tell_place(const SmoothingSystem& system, const KnotCluster& knots, double step, CurvatureStep& joint,
                double ahead_mm) {
    const double told = std::clamp(system.told(knots.first), least_told, 1.0);
    const double known_variance = system.roughness().variance()[knots.first];
    joint.told_t = joint.t + ahead_mm + off_expected_mm(system, knots, step) / told;
    joint.told_sigma_mm = std::sqrt(known_variance * (1.0 - told) / told) / std::abs(turn_per_mm(step, knots.apart));
}

}  // namespace cmm::fitting
