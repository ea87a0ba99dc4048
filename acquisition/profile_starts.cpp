// SPDX-License-Identifier: Apache-2.0
#include "acquisition/profile_starts.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace cmm::acquisition {
namespace {

using Figure = std::vector<std::complex<double>>;

constexpr std::size_t most_compared = 200;  // of the points of a profile, for one start
// Another start has to fit better by this: profiles of one drawing differ in form, which no start can take away.
constexpr double clearly_better = 0.5;
constexpr double alike_already = 1e-7;  // a micrometre of some millimetres, squared; a circle fits itself from anywhere
constexpr double between_points = 0.2;  // of the distance of two of them

/// About its centre, as complex numbers: one factor turns and scales it.
Figure figure_of(const std::vector<Eigen::Vector2d>& profile) {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    for (const auto& point : profile)
        centre += point / static_cast<double>(profile.size());
    Figure figure;
    figure.reserve(profile.size());
    for (const auto& point : profile)
        figure.emplace_back(point.x() - centre.x(), point.y() - centre.y());
    return figure;
}

/// What is left when `above`, begun `start` points later, is laid onto `below`: a share of its size, squared.
double misfit(const Figure& below, const Figure& above, std::size_t start) {
    const std::size_t n = below.size(), step = (n - 1) / most_compared + 1;
    std::complex<double> product = 0.0;
    double size_below = 0.0, size_above = 0.0;
    for (std::size_t i = 0; i < n; i += step) {
        const auto& p = below[i];
        const auto& q = above[(i + start) % n];
        product += std::conj(p) * q;
        size_below += std::norm(p);
        size_above += std::norm(q);
    }
    // Both ends of a slender section look alike from afar: what is turned by more than a right angle begins elsewhere.
    const double turn = std::abs(std::arg(product));
    const double alike = std::abs(product) * (turn > 0.5 * std::numbers::pi ? std::sin(turn) : 1.0);
    return 1.0 - alike * alike / (size_below * size_above);
}

struct Start {
    std::size_t point = 0;
    double beside = 0.0;  ///< the best place, from that point on, as a share of the distance to the next one
};

/// Another start than the first has to fit better by the factor `than_first`.
Start start_opposite(const Figure& below, const Figure& above, double than_first) {
    const std::size_t n = below.size();
    std::vector<double> misfits(n);
    for (std::size_t k = 0; k < n; ++k)
        misfits[k] = misfit(below, above, k);
    const auto best = static_cast<std::size_t>(std::min_element(misfits.begin(), misfits.end()) - misfits.begin());
    if (misfits[0] < alike_already) return {};
    Start start{misfits[best] < than_first * misfits[0] ? best : 0, 0.0};
    // The lowest place of the parabola through three misfits.
    const double here = misfits[start.point], before = misfits[(start.point + n - 1) % n],
                 after = misfits[(start.point + 1) % n];
    const double bend = before - 2.0 * here + after;
    if (bend > 0.0) start.beside = 0.5 * (before - after) / bend;
    return start;
}

}  // namespace

bool ProfileStarts::all_at_first() const noexcept {
    return std::all_of(first.begin(), first.end(), [](std::size_t start) { return start == 0; });
}

ProfileStarts profile_starts(const std::vector<std::vector<Eigen::Vector2d>>& profiles) {
    ProfileStarts starts;
    Figure below;
    for (const auto& profile : profiles) {
        Figure figure = figure_of(profile);
        const Start start = below.empty() ? Start{} : start_opposite(below, figure, clearly_better);
        starts.first.push_back(start.point);
        starts.points_agree = starts.points_agree && std::abs(start.beside) < between_points;
        std::rotate(figure.begin(), figure.begin() + static_cast<std::ptrdiff_t>(start.point), figure.end());
        below = std::move(figure);
    }
    return starts;
}

double share_opposite(const std::vector<Eigen::Vector2d>& below, const std::vector<Eigen::Vector2d>& above) {
    const auto start = start_opposite(figure_of(below), figure_of(above), 1.0);
    const double share = (static_cast<double>(start.point) + start.beside) / static_cast<double>(above.size());
    return share > 0.5 ? share - 1.0 : share;
}

}  // namespace cmm::acquisition
