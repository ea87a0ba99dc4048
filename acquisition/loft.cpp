// SPDX-License-Identifier: Apache-2.0
#include "acquisition/loft.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmm::acquisition {
namespace {

using Profile = std::vector<Eigen::Vector3d>;

constexpr std::size_t coarse_per_span = 12;

std::vector<double> cumulative(double first, const std::vector<double>& steps) {
    std::vector<double> knots{first};
    for (const double step : steps)
        knots.push_back(knots.back() + step);
    return knots;
}

/// Chord lengths to the next point (the last: to the first), averaged over the profiles.
std::vector<double> mean_chords_along(const std::vector<Profile>& profiles) {
    const std::size_t n = profiles.front().size();
    std::vector<double> chords(n, 0.0);
    for (const auto& profile : profiles) {
        for (std::size_t i = 0; i < n; ++i)
            chords[i] += (profile[(i + 1) % n] - profile[i]).norm();
    }
    for (double& chord : chords)
        chord /= static_cast<double>(profiles.size());
    return chords;
}

std::vector<double> mean_chords_across(const std::vector<Profile>& profiles) {
    std::vector<double> chords;
    for (std::size_t k = 0; k + 1 < profiles.size(); ++k) {
        double sum = 0.0;
        for (std::size_t i = 0; i < profiles[k].size(); ++i)
            sum += (profiles[k + 1][i] - profiles[k][i]).norm();
        chords.push_back(sum / static_cast<double>(profiles[k].size()));
    }
    return chords;
}

/// Where the height of the spline across equals z: the span is bracketed by its knots, then bisection guards Newton.
double parameter_at_height(const CubicSpline& across, const std::vector<double>& knots, double z) {
    std::size_t k = 0;
    while (k + 2 < knots.size() && across.value(knots[k + 1]).z() < z)
        ++k;
    double low = knots[k], high = knots[k + 1];
    double v = 0.5 * (low + high);
    for (int i = 0; i < 100; ++i) {
        const double miss = across.value(v).z() - z;
        if (std::abs(miss) < 1e-12 || high - low < 1e-13 * (1.0 + std::abs(high))) break;
        (miss > 0.0 ? high : low) = v;
        const double slope = across.first(v).z();
        const double newton = v - miss / slope;
        v = slope > 0.0 && newton > low && newton < high ? newton : 0.5 * (low + high);
    }
    return v;
}

}  // namespace

Loft::Loft(std::vector<Profile> profiles) {
    const auto knots = cumulative(0.0, mean_chords_along(profiles));
    across_knots_ = cumulative(0.0, mean_chords_across(profiles));
    for (auto& profile : profiles)
        along_.push_back(CubicSpline::periodic(knots, std::move(profile)));
    z_low_ = std::numeric_limits<double>::lowest();
    z_high_ = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
        for (std::size_t j = 0; j < coarse_per_span; ++j) {
            const double u = knots[i] + (knots[i + 1] - knots[i]) * static_cast<double>(j) / coarse_per_span;
            coarse_.push_back(u);
            z_low_ = std::max(z_low_, along_.front().value(u).z());
            z_high_ = std::min(z_high_, along_.back().value(u).z());
        }
    }
}

CutPoint Loft::at(double u, double z_mm) const {
    Profile column;
    column.reserve(along_.size());
    for (const auto& spline : along_)
        column.push_back(spline.value(u));
    const auto across = CubicSpline::natural(across_knots_, std::move(column));
    const double v = parameter_at_height(across, across_knots_, z_mm);
    return {across.value(v).head<2>(), across.first(v)};
}

std::vector<CutPoint> Loft::cut(double z_mm) const {
    const auto& knots = along_.front().knots();
    const auto position = [&](double u) { return at(u, z_mm).position_mm; };
    const auto parameters = dense_parameters(position, coarse_, knots.back() - knots.front());
    std::vector<CutPoint> points(parameters.size());
    std::transform(parameters.begin(), parameters.end(), points.begin(), [&](double u) { return at(u, z_mm); });
    return points;
}

}  // namespace cmm::acquisition
