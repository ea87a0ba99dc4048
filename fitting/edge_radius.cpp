// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_radius.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/text.hpp"
#include "fitting/circle.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t places = 121;
constexpr double most_of_perimeter = 0.25;  // to either side; beyond that the window is no edge's
constexpr double tried_turn_rad = 0.5 * std::numbers::pi / 180.0;  // of an end
constexpr double nose_sigma_rad = 0.2 * std::numbers::pi / 180.0;  // of its normal: 0.05 to 0.17, whatever the noise
constexpr double circular_in_noise = 1.2;                          // of the noise, what points of an arc leave off it
constexpr double double_arc_in_u95 = 2.0;  // two arcs are named where noise makes them most different
constexpr double inner_share = 0.7;        // of a window, whose circle says where its ends should lie
constexpr double least_inner_rad = 70.0 * std::numbers::pi / 180.0;  // clear of what is too short for a circle
constexpr double off_arc_mm = 0.5e-3;                                // that needs no noise to excuse it

/// Round a contour from a place on it, one way: step 0 is that place, the others are the points behind it.
class Walk {
  public:
    Walk(const ContourGeometry& contour, const ContourPlace& from, bool forwards)
        : contour_(contour), from_(from), forwards_(forwards), start_{contour.position(from), contour.normal(from)} {}

    struct Mark {
        Vec2 position, normal;
    };
    Mark at(std::size_t step) const {
        if (step == 0) return start_;
        const ContourPoint& point = contour_.point(forwards_ ? from_.index + step : back(step - 1));
        return {point.position_mm, point.normal};
    }
    /// The place that lies a share of the way from one step to the next.
    ContourPlace between(std::size_t step, double share) const {
        if (forwards_) {
            if (step == 0) return {from_.index, from_.share + share * (1.0 - from_.share)};
            return {(from_.index + step) % contour_.size(), share};
        }
        if (step == 0) return {from_.index, from_.share * (1.0 - share)};
        return {back(step), 1.0 - share};
    }

  private:
    std::size_t back(std::size_t steps) const {
        const std::size_t n = contour_.size();
        return (from_.index + n - steps % n) % n;
    }

    const ContourGeometry& contour_;
    ContourPlace from_;
    bool forwards_;
    Mark start_;
};

/// Of the nose: `foot` of a whole contour sees no place between its last point and its first.
ContourPlace place_of(const ContourGeometry& contour, const Vec2& nose) {
    constexpr std::size_t around = 8;
    return contour.foot(nose, {contour.nearest_point(nose) + contour.size() - around, 2 * around + 1});
}

/// Lengths and places from the nose to where the window ends on one side.
struct Side {
    std::vector<double> length{0.0};  // at the points passed
    double end_mm = 0.0;
    double turn_rad = 0.0;
};

tl::unexpected<core::Error> no_window(const std::string& why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, "the window of the radius " + why);
}

ContourPlace place_on(const Walk& walk, const Side& side, double length_mm) {
    const auto after = std::upper_bound(side.length.begin() + 1, side.length.end() - 1, length_mm);
    const auto step = static_cast<std::size_t>(after - side.length.begin()) - 1;
    const double span = side.length[step + 1] - side.length[step];
    return walk.between(step, span > 0.0 ? std::clamp((length_mm - side.length[step]) / span, 0.0, 1.0) : 0.0);
}

/// About the nose of an edge.
class WindowFinder {
  public:
    WindowFinder(const ContourGeometry& contour, const Vec2& nose)
        : contour_(contour),
          nose_(nose),
          forwards_(contour, place_of(contour, nose), true),
          backwards_(contour, place_of(contour, nose), false) {}

    struct Found {
        std::array<ContourPlace, places> at;
        Circle circle;
        ContourPlace first, last;
        double arc_rad = 0.0;
    };
    core::Result<Found> find(const RadiusWindow& before, const RadiusWindow& behind) const;

  private:
    core::Result<Side> side_of(const Walk& walk, const RadiusWindow& window) const;

    const ContourGeometry& contour_;
    Vec2 nose_;
    Walk forwards_, backwards_;
};

core::Result<Side> WindowFinder::side_of(const Walk& walk, const RadiusWindow& window) const {
    Side side;
    double before = 0.0;
    for (std::size_t step = 0; side.length.back() < most_of_perimeter * contour_.perimeter(); ++step) {
        const Walk::Mark here = walk.at(step), next = walk.at(step + 1);
        const double turn = std::abs(turn_between(here.normal, next.normal));
        const double length = (next.position - here.position).norm();
        const double wanted = window.arc_rad ? 0.5 * *window.arc_rad : *window.reach_mm;
        const double now = window.arc_rad ? side.turn_rad + turn : (next.position - nose_).norm();
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
    return no_window("reaches beyond the edge");
}

core::Result<WindowFinder::Found> WindowFinder::find(const RadiusWindow& before, const RadiusWindow& behind) const {
    const auto back = side_of(backwards_, before), forth = side_of(forwards_, behind);
    if (!forth) return tl::unexpected(forth.error());
    if (!back) return tl::unexpected(back.error());
    Found found;
    std::vector<Vec2> points;
    const double length = back->end_mm + forth->end_mm;
    const auto place = [&](double s) {
        return s >= 0.0 ? place_on(forwards_, *forth, s) : place_on(backwards_, *back, -s);
    };
    for (std::size_t k = 0; k < places; ++k) {
        found.at[k] = place(length * (static_cast<double>(k) + 0.5) / static_cast<double>(places) - back->end_mm);
        points.push_back(contour_.position(found.at[k]));
    }
    const auto circle = fit_circle(points);
    if (!circle) return tl::unexpected(circle.error());
    found.circle = *circle;
    found.first = place(-back->end_mm);
    found.last = place(forth->end_mm);
    found.arc_rad = back->turn_rad + forth->turn_rad;
    return found;
}

/// How a number of the fitted circle answers to each place's displacement: `row`, times the centre's and the radius's.
void add_circle(const ContourGeometry& contour, const WindowFinder::Found& window, const Eigen::Vector3d& row,
                double factor, Sensitivity& number) {
    std::array<Eigen::Vector3d, places> rows;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < places; ++k) {
        const Vec2 out = (contour.position(window.at[k]) - window.circle.centre).normalized();
        rows[k] << out, 1.0;
        normal += rows[k] * rows[k].transpose();
    }
    const Eigen::Vector3d of_number = factor * normal.ldlt().solve(row);
    for (std::size_t k = 0; k < places; ++k)
        contour.add(window.at[k], rows[k].dot(of_number), number);
}

/// A displacement's slope turns the normal at an end, and the end goes to where the contour has turned so much more or
/// less. The nose's normal is that of the sides far from the edge, but where these begin is told by the edge's flattest
/// property, the place of its sharpest arc: that doubt moves both ends alike.
core::Status add_ends(const ContourGeometry& contour, const WindowFinder& finder, double arc_rad,
                      const WindowFinder::Found& found, Measure& radius) {
    const RadiusWindow window{arc_rad, {}};
    const RadiusWindow less{arc_rad - 2.0 * tried_turn_rad, {}}, more{arc_rad + 2.0 * tried_turn_rad, {}};
    const auto first_less = finder.find(less, window), first_more = finder.find(more, window);
    const auto last_less = finder.find(window, less), last_more = finder.find(window, more);
    for (const auto* const tried : {&first_less, &first_more, &last_less, &last_more})
        if (!*tried) return tl::unexpected(tried->error());
    const auto by_turn = [](const WindowFinder::Found& less_turned, const WindowFinder::Found& more_turned) {
        return (more_turned.circle.radius - less_turned.circle.radius) / (2.0 * tried_turn_rad);
    };
    const double by_first = by_turn(*first_less, *first_more), by_last = by_turn(*last_less, *last_more);
    contour.add_slope(found.first, -by_first, radius.slopes);
    contour.add_slope(found.last, by_last, radius.slopes);
    radius.beside.variance = std::pow(nose_sigma_rad * (by_last - by_first), 2);
    return {};
}

/// As far as the points can tell: an arc in all but name, too.
bool is_arc(const EdgeFit& edge, double noise_mm) {
    if (!edge.valid) return false;
    if (edge.model == EdgeModel::free) return edge.rms_mm < circular_in_noise * noise_mm;
    if (edge.model != EdgeModel::double_arc) return edge.model == EdgeModel::arc;
    const EdgeParameter &first = edge.parameters[0], &second = edge.parameters[1];
    return std::abs(first.value - second.value) < double_arc_in_u95 * (first.u95 + second.u95);
}

/// An end beyond an arc lies on the side, which turns so little that the doubt of the nose moves it by as much as the
/// edge is wide: the radius is then neither the arc's nor one that could be found again. The arc is that of the
/// window's inner part, of the same contour.
core::Status stays_on_arc(const MeasuredSection& section, const WindowFinder& finder, double arc_rad,
                          const WindowFinder::Found& window) {
    const ContourGeometry& contour = section.contour();
    const RadiusWindow inner_window{std::max(inner_share * arc_rad, std::min(arc_rad, least_inner_rad)), {}};
    const auto inner = finder.find(inner_window, inner_window);
    if (!inner) return tl::unexpected(inner.error());
    for (const ContourPlace& end : {window.first, window.last}) {
        const Vec2 from_centre = contour.position(end) - inner->circle.centre;
        Measure off{"", from_centre.norm() - inner->circle.radius, {}, {}};
        contour.add(end, 1.0, off.slopes);
        const Vec2 out = from_centre.normalized();
        add_circle(contour, *inner, {out.x(), out.y(), 1.0}, -1.0, off.slopes);
        if (std::abs(off.value) > off_arc_mm + 3.0 * section.uncertainty(off).u95)
            return no_window("reaches over the joint between edge and side, to " +
                             core::length_text(std::abs(off.value)) +
                             " off the arc of the edge: a narrower one is needed");
    }
    return {};
}

}  // namespace

core::Result<WindowRadius> measure_edge_radius(MeasuredSection& section, EdgeName edge, const RadiusWindow& window) {
    const ContourGeometry& contour = section.contour();
    const bool le = edge == EdgeName::le;
    const SectionFit& fit = section.fit();
    const WindowFinder finder(contour, le ? fit.le_point_mm : fit.te_point_mm);
    const auto found = finder.find(window, window);
    if (!found) return tl::unexpected(found.error());
    WindowRadius out;
    out.radius.method = "LSQ circle by orthogonal distances through a window of the edge";
    out.radius.value = found->circle.radius;
    out.arc_rad = found->arc_rad;
    out.rms_mm = found->circle.rms;
    add_circle(contour, *found, Eigen::Vector3d::UnitZ(), 1.0, out.radius.slopes);
    if (!window.arc_rad) return out;
    if (const EdgeFit& shape = le ? fit.le : fit.te; is_arc(shape, fit.noise_sigma_mm))
        if (auto status = stays_on_arc(section, finder, *window.arc_rad, *found); !status)
            return tl::unexpected(status.error());
    if (auto status = add_ends(contour, finder, *window.arc_rad, *found, out.radius); !status)
        return tl::unexpected(status.error());
    return out;
}

}  // namespace cmm::fitting
