// SPDX-License-Identifier: Apache-2.0
// A stranger's program: an ellipse-like blade of 40 mm chord measured with a 1 mm ball comes back as a closed section.
#include <cmath>
#include <cstdio>
#include <vector>

#include "fitting/section.hpp"

int main() {
    constexpr double a = 20.0;
    constexpr double b = 2.0;
    constexpr double ball_mm = 1.0;
    std::vector<Eigen::Vector2d> centres;
    for (int i = 0; i < 1200; ++i) {
        const double t = 2.0 * 3.14159265358979323846 * i / 1200;
        const Eigen::Vector2d normal = Eigen::Vector2d(b * std::cos(t), a * std::sin(t)).normalized();
        centres.emplace_back(Eigen::Vector2d(a * std::cos(t), b * std::sin(t)) + ball_mm * normal);
    }
    cmm::fitting::SectionOptions options;
    options.ball_radius_mm = ball_mm;
    const auto fit = cmm::fitting::fit_section(centres, {}, options);
    if (!fit) {
        std::fprintf(stderr, "%s\n", fit.error().text().c_str());
        return 1;
    }
    double worst = 0.0;
    for (const auto& point : fit->contour) {
        const auto& p = point.position_mm;
        const double level = p.x() * p.x() / (a * a) + p.y() * p.y() / (b * b) - 1.0;
        const double slope = 2.0 * std::hypot(p.x() / (a * a), p.y() / (b * b));
        worst = std::max(worst, std::abs(level) / slope);
    }
    std::printf("contour %zu points, worst deviation %.4f um\n", fit->contour.size(), worst * 1e3);
    return fit->missing.empty() && worst < 0.01 ? 0 : 1;
}
