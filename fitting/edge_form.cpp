// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_form.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/text.hpp"

namespace cmm::fitting {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr double widest_gap_rad = 30.0 * degree;
constexpr double flat_turn_rad = 12.0 * degree;
constexpr double corner_turn_rad = 40.0 * degree;
constexpr double square_ratio = 4.0;  // of the flat to the corners' radius; a circle has 0.2, an ellipse 1:2 0.6
constexpr double blunt_ratio = 1.0;
constexpr std::size_t least_flat_points = 4;

}  // namespace

std::string FormFinding::text() const {
    switch (form) {
        case EdgeForm::partial:
            return "partial: no points over " + core::fixed(gap_rad / degree, 0) + " degrees of the edge";
        case EdgeForm::square:
            return "square end: a flat of " + core::length_text(flat_mm) + " between corners of " +
                   core::length_text(corner_radius_mm) + " radius";
        case EdgeForm::blunt:
            return "blunt end: a flat of " + core::length_text(flat_mm) + " between roundings of " +
                   core::length_text(corner_radius_mm) + " radius";
        case EdgeForm::round:
            break;
    }
    return {};
}

FormFinding recognise_form(const EdgePoints& edge, std::size_t begin, std::size_t end) {
    FormFinding finding;
    if (end > edge.points.size() || end < begin + 3) return finding;
    const std::size_t n = end - begin;
    std::vector<double> s(n, 0.0), angle(n, 0.0);  // of the part
    for (std::size_t k = 1; k < n; ++k) {
        const EdgePoint &a = edge.points[begin + k - 1], &b = edge.points[begin + k];
        const double turn = turn_angle(a.normal, b.normal);
        finding.gap_rad = std::max(finding.gap_rad, turn);
        const Vec2 step = (b.centre - edge.ball_mm * b.normal) - (a.centre - edge.ball_mm * a.normal);
        const Vec2 normal = a.normal + b.normal;
        s[k] = s[k - 1] + cross(normal, step) / normal.norm();  // along the tangent: noise does not add up
        angle[k] = angle[k - 1] + turn;
    }
    if (finding.gap_rad > widest_gap_rad) {
        finding.form = EdgeForm::partial;
        return finding;
    }
    for (std::size_t i = 0, j = 0; i < n; ++i) {
        j = std::max(j, i);
        while (j + 1 < n && std::abs(angle[j + 1] - angle[i]) <= flat_turn_rad)
            ++j;
        const bool between = angle[i] >= corner_turn_rad && angle[n - 1] - angle[j] >= corner_turn_rad;
        if (!between || j - i + 1 < least_flat_points || s[j] - s[i] <= finding.flat_mm) continue;
        finding.flat_mm = s[j] - s[i];
        const double turned = angle[n - 1] - (angle[j] - angle[i]);
        finding.corner_radius_mm = (s[n - 1] - finding.flat_mm) / std::max(turned, 0.1);
    }
    if (finding.flat_mm >= square_ratio * finding.corner_radius_mm && finding.flat_mm > 0.0)
        finding.form = EdgeForm::square;
    else if (finding.flat_mm >= blunt_ratio * finding.corner_radius_mm && finding.flat_mm > 0.0)
        finding.form = EdgeForm::blunt;
    return finding;
}

}  // namespace cmm::fitting
