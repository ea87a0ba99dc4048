// SPDX-License-Identifier: Apache-2.0
#include "fitting/camber_line_builder.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace cmm::fitting {
namespace {

constexpr double most_steps_in_chord = 60.0;
constexpr double step_in_radii = 0.5;
constexpr double least_step_share = 0.05;     // of the edge's scale
constexpr double nearest_scales = 1.5;        // to a nose: nearer, the circle is the edge
constexpr double first_scales = 2.0;          // where the circles begin that continue the line
constexpr double camber_window_share = 0.12;  // of the perimeter: about a quarter of the chord
constexpr std::size_t window_circles = 25;
constexpr std::size_t least_circles = 8;  // of a continuation, and of a line
constexpr double searched_scales = 4.0;   // about a nose, for the place where the line leaves
constexpr int rounds_of_end = 6;
constexpr double standing_mm = 2e-5;  // from one round to the next
constexpr int points_in_end = 24;
constexpr double largest_arc = 1000.0;  // radius in window's ends
constexpr double smallest_arc = 1.05;   // radius in reaches of the line over it

core::Status refuse(const char* why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, why);
}

/// The circle y = a (x^2 + y^2) + b x + d that leaves least of the ordinates: where the centres bend both ways it is as
/// straight as they are on the whole (Kasa's is then a small one). Straight where it is too small for the line to be a
/// function of x over it, or too large to matter: its ordinates differ from a cubic by x^4/(8 r^3). To first order the
/// cubic takes up what moves the arc.
CamberEnd::Arc arc_through(const std::vector<Vec2>& centres, double last_mm, double scale_mm) {
    Eigen::MatrixX3d design(static_cast<Eigen::Index>(centres.size()), 3);
    Eigen::VectorXd ordinates(design.rows());
    for (std::size_t i = 0; i < centres.size(); ++i) {
        const Vec2 p = centres[i] / last_mm;
        design.row(static_cast<Eigen::Index>(i)) << p.squaredNorm(), p.x(), 1.0;
        ordinates[static_cast<Eigen::Index>(i)] = p.y();
    }
    const Eigen::Vector3d circle = design.colPivHouseholderQr().solve(ordinates);
    const double bend = 2.0 * circle[0];
    if (!(std::abs(bend) * largest_arc > 1.0)) return {};
    const Vec2 centre(-circle[1] / bend * last_mm, last_mm / bend);
    const double square = circle[1] * circle[1] + 1.0 - 2.0 * bend * circle[2];
    const double radius = std::sqrt(std::max(square, 0.0)) / std::abs(bend) * last_mm;
    const double farthest = std::max(last_mm - centre.x(), centre.x() + nearest_scales * scale_mm);
    if (!(radius > smallest_arc * farthest)) return {};
    return {centre, radius, bend > 0.0 ? -1.0 : 1.0};
}

}  // namespace

CamberLineBuilder::CamberLineBuilder(const SectionFit& fit, CamberLine& line)
    : fit_(fit), line_(line), contour_(*line.contour_), chord_mm_((fit.te_point_mm - fit.le_point_mm).norm()) {}

/// From the middle of the suction side inwards, where both sides are equally near.
std::optional<InscribedCircle> CamberLineBuilder::first_circle() const {
    const ContourRange& suction = line_.sides_.suction;
    for (const double share : {0.5, 0.4, 0.6, 0.3, 0.7}) {
        const auto k = static_cast<std::size_t>(share * static_cast<double>(suction.count));
        const ContourPoint& p = contour_.point(suction.first + k);
        const Vec2 opposite = contour_.position(contour_.foot(p.position_mm, line_.sides_.pressure));
        const double depth = 0.5 * (p.position_mm - opposite).norm();
        if (auto circle = line_.finder_.on_line(p.position_mm - depth * p.normal, p.normal)) return circle;
    }
    return {};
}

std::vector<InscribedCircle> CamberLineBuilder::march(const InscribedCircle& from, const Vec2& forward,
                                                      const Vec2& nose, double scale_mm) const {
    std::vector<InscribedCircle> circles;
    InscribedCircle last = from;
    Vec2 along = from.along(forward);
    const double longest = chord_mm_ / most_steps_in_chord, least = least_step_share * scale_mm;
    const auto most = static_cast<std::size_t>(40.0 * most_steps_in_chord);
    while (circles.size() < most && (last.centre - nose).norm() > nearest_scales * scale_mm) {
        const double step = std::clamp(step_in_radii * last.radius, least, longest);
        const auto next = line_.finder_.on_line(last.centre + step * along, line_.across(along, last));
        // Past a bump the centre may jump, but the line does not turn back.
        if (!next || (next->centre - last.centre).dot(along) < 0.0 || next->radius < 0.05 * scale_mm) break;
        if ((next->centre - last.centre).norm() > 4.0 * step) break;
        along = next->along(along);
        circles.push_back(*next);
        last = *next;
    }
    return circles;
}

core::Status CamberLineBuilder::run() {
    if (!(chord_mm_ > 0.0) || !(fit_.le_scale_mm > 0.0) || !(fit_.te_scale_mm > 0.0))
        return refuse("camber line: the section has no two edges");
    const auto middle = first_circle();
    if (!middle) return refuse("camber line: no circle fits between the sides");
    const Vec2 forward = fit_.te_point_mm - fit_.le_point_mm;
    auto to_le = march(*middle, -forward, fit_.le_point_mm, fit_.le_scale_mm);
    const auto to_te = march(*middle, forward, fit_.te_point_mm, fit_.te_scale_mm);
    line_.circles_.assign(to_le.rbegin(), to_le.rend());
    line_.circles_.push_back(*middle);
    line_.circles_.insert(line_.circles_.end(), to_te.begin(), to_te.end());
    if (line_.circles_.size() < 2 * least_circles) return refuse("camber line: too few inscribed circles");
    if (auto status = continue_to(fit_.le_point_mm, line_.sides_.le, fit_.le_scale_mm, true, line_.le_); !status)
        return status;
    if (auto status = continue_to(fit_.te_point_mm, line_.sides_.te, fit_.te_scale_mm, false, line_.te_); !status)
        return status;
    join();
    if (line_.circles_.size() < least_circles) return refuse("camber line: too few inscribed circles");
    return {};
}

/// All distances count from the point that the continuation gives, not from where the edge was found to be sharpest, so
/// that the point depends on the sides alone.
core::Status CamberLineBuilder::continue_to(const Vec2& nose, std::size_t nose_index, double scale_mm, bool le,
                                            CamberEnd& end) const {
    const auto& circles = line_.circles_;
    const double last_mm = first_scales * scale_mm + camber_window_share * contour_.perimeter();
    end.point_ = nose;
    for (int round = 0; round < rounds_of_end; ++round) {
        const InscribedCircle *near = nullptr, *far = nullptr;
        for (std::size_t k = 0; k < circles.size() && far == nullptr; ++k) {
            const InscribedCircle& circle = circles[le ? k : circles.size() - 1 - k];
            ((circle.centre - end.point_).norm() >= last_mm ? far : near) = &circle;
        }
        if (far == nullptr || near == nullptr) return refuse("camber line: no inscribed circles towards an end");
        const double from = (near->centre - end.point_).norm(), to = (far->centre - end.point_).norm();
        const Vec2 mark = near->centre + (last_mm - from) / (to - from) * (far->centre - near->centre);
        end.origin_ = end.point_;
        end.axis_ = (mark - end.origin_).normalized();
        end.first_mm_ = first_scales * scale_mm;
        end.unit_mm_ = last_mm;
        end.across_ = line_.across(end.axis_, *far);
        end.circles_.clear();
        if (auto status = fit_cubic(le, end, last_mm, scale_mm); !status) return status;
        if (auto status = leave_contour(nose_index, scale_mm, end); !status) return status;
        if ((end.point_ - end.origin_).norm() < standing_mm) break;
    }
    return {};
}

core::Status CamberLineBuilder::fit_cubic(bool le, CamberEnd& end, double last_mm, double scale_mm) const {
    const auto& circles = line_.circles_;
    const auto x_of = [&](std::size_t k) {
        return (circles[le ? k : circles.size() - 1 - k].centre - end.origin_).dot(end.axis_);
    };
    std::vector<Vec2> centres;  // in the frame of the cubic
    std::size_t k = 0;
    for (std::size_t i = 0; i < window_circles; ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(window_circles - 1);
        const double x = end.first_mm_ + share * (last_mm - end.first_mm_);
        while (k + 2 < circles.size() && x_of(k + 1) < x)
            ++k;
        const double part = (x - x_of(k)) / (x_of(k + 1) - x_of(k));
        const Vec2 &a = circles[le ? k : circles.size() - 1 - k].centre,
                   &b = circles[le ? k + 1 : circles.size() - 2 - k].centre;
        if (!(part > -0.5 && part < 1.5)) continue;
        const auto circle = line_.finder_.on_line(a + part * (b - a), end.across_);
        if (!circle) continue;
        end.circles_.push_back(*circle);
        const Vec2 off = circle->centre - end.origin_;
        centres.emplace_back(off.dot(end.axis_), off.dot(left_of(end.axis_)));
    }
    if (centres.size() < least_circles) return refuse("camber line: too few inscribed circles towards an end");
    lay_cubic(centres, scale_mm, end);
    return {};
}

void CamberLineBuilder::lay_cubic(const std::vector<Vec2>& centres, double scale_mm, CamberEnd& end) {
    Eigen::Matrix<double, Eigen::Dynamic, 4> design(static_cast<Eigen::Index>(centres.size()), 4);
    for (std::size_t i = 0; i < centres.size(); ++i)
        design.row(static_cast<Eigen::Index>(i)) = end.powers(centres[i].x());
    const Eigen::Matrix4d normal = design.transpose() * design;
    end.fit_ = normal.ldlt().solve(design.transpose());
    end.arc_ = arc_through(centres, end.unit_mm_, scale_mm);
    Eigen::VectorXd beside(design.rows());
    for (std::size_t i = 0; i < centres.size(); ++i)
        beside[static_cast<Eigen::Index>(i)] = centres[i].y() - end.arc_.ordinate(centres[i].x());
    end.cubic_ = end.fit_ * beside;
}

/// Where the cubic crosses the contour, farthest outside.
core::Status CamberLineBuilder::leave_contour(std::size_t nose_index, double scale_mm, CamberEnd& end) const {
    const std::size_t n = contour_.size();
    const auto beside = [&](const Vec2& p) {
        const Vec2 off = p - end.origin_;
        return off.dot(left_of(end.axis_)) - end.ordinate(off.dot(end.axis_));
    };
    const auto far = [&](std::size_t i) {
        return (contour_.point(i).position_mm - end.origin_).norm() > searched_scales * scale_mm;
    };
    std::size_t first = nose_index + n, last = nose_index + n;
    while (first > nose_index + n / 2 && !far(first))
        --first;
    while (last < nose_index + n + n / 2 && !far(last))
        ++last;
    double outermost = std::numeric_limits<double>::infinity();
    for (std::size_t i = first; i < last; ++i) {
        double low = 0.0, high = 1.0;
        const double at_low = beside(contour_.point(i).position_mm);
        if ((at_low > 0.0) == (beside(contour_.point(i + 1).position_mm) > 0.0)) continue;
        for (int step = 0; step < 48; ++step) {
            const double middle = 0.5 * (low + high);
            ((beside(contour_.position({i % n, middle})) > 0.0) == (at_low > 0.0) ? low : high) = middle;
        }
        const ContourPlace place{i % n, low};
        const double x = (contour_.position(place) - end.origin_).dot(end.axis_);
        if (x >= outermost) continue;
        outermost = x;
        end.place_ = place;
    }
    if (!std::isfinite(outermost)) return refuse("camber line: it does not leave the section at an edge");
    end.x_ = outermost;
    end.point_ = contour_.position(end.place_);
    end.inward_ = end.direction(end.x_);
    // n . dN is what the contour moves by, left_of(inward) . dN what the line moves by.
    const Vec2 normal = contour_.normal(end.place_), left = left_of(end.inward_);
    const double determinant = cross(normal, left);
    if (std::abs(determinant) < 0.1) return refuse("camber line: it leaves the section along an edge");
    end.by_normal_ = Vec2(left.y(), -left.x()) / determinant;
    end.by_camber_ = Vec2(-normal.y(), normal.x()) / determinant * left.dot(left_of(end.axis_));
    return {};
}

void CamberLineBuilder::join() {
    auto& points = line_.points_;
    auto& circles = line_.circles_;
    const auto inside = [&](const CamberEnd& end, const InscribedCircle& circle) {
        return (circle.centre - end.origin_).dot(end.axis_) >= end.first_mm_;
    };
    std::size_t first = 0, last = circles.size();
    while (first < last && !inside(line_.le_, circles[first]))
        ++first;
    while (last > first && !inside(line_.te_, circles[last - 1]))
        --last;
    circles.erase(circles.begin() + static_cast<std::ptrdiff_t>(last), circles.end());
    circles.erase(circles.begin(), circles.begin() + static_cast<std::ptrdiff_t>(first));
    const auto add_end = [&](const CamberEnd& end, bool inwards) {
        for (int k = 0; k < points_in_end; ++k) {
            const double share = static_cast<double>(inwards ? k : points_in_end - k) / points_in_end;
            if (!inwards || k > 0 || points.empty())
                points.push_back(end.on_cubic(end.x_ + share * (end.first_mm_ - end.x_)));
        }
        if (!inwards) points.push_back(end.point_);
    };
    add_end(line_.le_, true);
    const std::size_t before = points.size();
    for (const InscribedCircle& circle : circles)
        points.push_back(circle.centre);
    const std::size_t after = points.size();
    add_end(line_.te_, false);
    double arc = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i > 0) arc += (points[i] - points[i - 1]).norm();
        if (i >= before && i < after) line_.arc_mm_.push_back(arc);
    }
    line_.length_mm_ = arc;
}

}  // namespace cmm::fitting
