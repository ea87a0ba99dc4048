// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_radius.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fitting/circle.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t places = 121;
constexpr double most_of_perimeter = 0.25;  // to either side; beyond that the window is no edge's

/// Round a contour from a point of it, one way.
class Walk {
  public:
    Walk(const ContourGeometry& contour, std::size_t from, bool forwards)
        : contour_(contour), from_(from), forwards_(forwards) {}

    const ContourPoint& at(std::size_t step) const { return contour_.point(index(step)); }
    std::size_t index(std::size_t step) const {
        const std::size_t n = contour_.size();
        return forwards_ ? (from_ + step) % n : (from_ + n - step % n) % n;
    }
    /// The place that lies a share of the way from one step to the next.
    ContourPlace between(std::size_t step, double share) const {
        if (forwards_) return {index(step), share};
        return {index(step + 1), 1.0 - share};
    }

  private:
    const ContourGeometry& contour_;
    std::size_t from_;
    bool forwards_;
};

/// Lengths and places from the nose to where the window ends on one side.
struct Side {
    std::vector<double> length{0.0};  // at the points passed
    double end_mm = 0.0;
    double turn_rad = 0.0;
};

core::Result<Side> side_of(const Walk& walk, const Vec2& nose, double perimeter, const RadiusWindow& window) {
    Side side;
    double before = 0.0;
    for (std::size_t step = 0; side.length.back() < most_of_perimeter * perimeter; ++step) {
        const ContourPoint &here = walk.at(step), &next = walk.at(step + 1);
        const double turn = std::abs(turn_between(here.normal, next.normal));
        const double length = (next.position_mm - here.position_mm).norm();
        const double wanted = window.arc_rad ? 0.5 * *window.arc_rad : *window.reach_mm;
        const double now = window.arc_rad ? side.turn_rad + turn : (next.position_mm - nose).norm();
        if (now >= wanted) {
            const double share = now > before ? std::clamp((wanted - before) / (now - before), 0.0, 1.0) : 1.0;
            side.end_mm = side.length.back() + share * length;
            side.turn_rad += share * turn;
            side.length.push_back(side.length.back() + length);
            return side;
        }
        before = now;
        side.turn_rad += turn;
        side.length.push_back(side.length.back() + length);
    }
    return core::fail(core::ErrorCode::fit_not_evaluable, "the window of the radius reaches beyond the edge");
}

ContourPlace place_on(const Walk& walk, const Side& side, double length_mm) {
    const auto after = std::upper_bound(side.length.begin() + 1, side.length.end() - 1, length_mm);
    const auto step = static_cast<std::size_t>(after - side.length.begin()) - 1;
    const double span = side.length[step + 1] - side.length[step];
    return walk.between(step, span > 0.0 ? std::clamp((length_mm - side.length[step]) / span, 0.0, 1.0) : 0.0);
}

/// The last row of the pseudo-inverse of the fit: how the radius answers to each place's displacement.
void add_slopes(const ContourGeometry& contour, const std::array<ContourPlace, places>& window, const Circle& circle,
                Sensitivity& radius) {
    std::array<Eigen::Vector3d, places> rows;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < places; ++k) {
        const Vec2 out = (contour.position(window[k]) - circle.centre).normalized();
        rows[k] << out, 1.0;
        normal += rows[k] * rows[k].transpose();
    }
    const Eigen::Vector3d of_radius = normal.ldlt().solve(Eigen::Vector3d::UnitZ());
    for (std::size_t k = 0; k < places; ++k)
        contour.add(window[k], rows[k].dot(of_radius), radius);
}

}  // namespace

core::Result<WindowRadius> measure_edge_radius(MeasuredSection& section, EdgeName edge, const RadiusWindow& window) {
    const ContourGeometry& contour = section.contour();
    const Vec2 nose = edge == EdgeName::le ? section.fit().le_point_mm : section.fit().te_point_mm;
    const std::size_t at = contour.nearest_point(nose);
    const Walk forwards(contour, at, true), backwards(contour, at, false);
    const auto after = side_of(forwards, nose, contour.perimeter(), window);
    const auto before = side_of(backwards, nose, contour.perimeter(), window);
    if (!after) return tl::unexpected(after.error());
    if (!before) return tl::unexpected(before.error());
    std::array<ContourPlace, places> stretch;
    std::vector<Vec2> points;
    const double length = before->end_mm + after->end_mm;
    for (std::size_t k = 0; k < places; ++k) {
        const double s = length * (static_cast<double>(k) + 0.5) / static_cast<double>(places) - before->end_mm;
        stretch[k] = s >= 0.0 ? place_on(forwards, *after, s) : place_on(backwards, *before, -s);
        points.push_back(contour.position(stretch[k]));
    }
    const auto circle = fit_circle(points);
    if (!circle) return tl::unexpected(circle.error());
    WindowRadius out;
    out.radius.method = "LSQ circle by orthogonal distances through a window of the edge";
    out.radius.value = circle->radius;
    out.arc_rad = before->turn_rad + after->turn_rad;
    out.rms_mm = circle->rms;
    add_slopes(contour, stretch, *circle, out.radius.slopes);
    return out;
}

}  // namespace cmm::fitting
