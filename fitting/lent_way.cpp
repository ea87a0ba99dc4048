// SPDX-License-Identifier: Apache-2.0
#include "fitting/lent_way.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace cmm::fitting {
namespace {

constexpr std::size_t most_marks = 64;  // points that are laid onto the way, evenly taken
constexpr std::size_t way_places = 720;
constexpr int laying_rounds = 15;
constexpr double lent_damping = 1e-3;               // of the number of points; turns in units of the nominal's size
constexpr double longest_step_share = 1.0 / 150.0;  // of the nominal's length
constexpr double most_step_turn_rad = 0.05, least_halving = 1e-4;
constexpr double left_weight = 20.0;
constexpr double lent_sigma_share = 0.25;  // of a step
constexpr double least_pace = 0.1;         // of the ball's way over the nominal's: less is a fold in a hollow

}  // namespace

LentWay::LentWay(const ClosedCurve& nominal, double ball_radius_mm, std::span<const Vec2> points, Sense sense)
    : nominal_(&nominal), ball_radius_mm_(ball_radius_mm) {
    for (std::size_t k = 0; k < way_places; ++k) {
        const CurvePoint at =
            nominal.evaluate(nominal.length() * static_cast<double>(k) / static_cast<double>(way_places));
        places_.push_back({at.position + ball_radius_mm * at.normal, at.normal});
    }
    lay_onto(marks_of(points, sense));
}

/// Where the ball went is told by the nearer of its neighbours: the other one may be on the other side of a gap.
std::vector<LentWay::Mark> LentWay::marks_of(std::span<const Vec2> points, Sense sense) {
    const std::size_t n = points.size(), stride = (n + most_marks - 1) / most_marks;
    std::vector<Mark> marks;
    for (std::size_t i = 0; i < n; i += stride) {
        const Vec2 in = points[i] - points[(i + n - 1) % n], out = points[(i + 1) % n] - points[i];
        const Vec2& along = in.squaredNorm() < out.squaredNorm() ? in : out;
        marks.push_back({points[i], sense == Sense::clockwise ? Vec2(-along) : along});
    }
    return marks;
}

/// That runs as the ball did, of the way as it lies now.
const LentWay::Place& LentWay::nearest(const Mark& mark) const {
    const Vec2 centre = motion_.undo(mark.centre), along = motion_.undo_on_direction(mark.along);
    const Place* best = &places_.front();
    double least = std::numeric_limits<double>::max();
    for (const Place& place : places_) {
        const double squared = (place.centre - centre).squaredNorm();
        if (squared >= least || left_of(place.normal).dot(along) <= 0.0) continue;
        least = squared;
        best = &place;
    }
    return *best;
}

void LentWay::lay_onto(std::span<const Mark> marks) {
    const double size_mm = nominal_->length() / 4.0, count = static_cast<double>(marks.size());
    for (const Mark& mark : marks)
        motion_.about_mm += mark.centre / count;
    double rms_mm = 0.0;
    for (int round = 0; round < laying_rounds; ++round) {
        Eigen::Matrix3d normal = lent_damping * count * Eigen::Matrix3d::Identity();
        Eigen::Vector3d moment = Eigen::Vector3d::Zero();
        double squares = 0.0;
        for (const Mark& mark : marks) {
            const Place& place = nearest(mark);
            const Vec2 n = motion_.apply_to_direction(place.normal);
            const double off_mm = (mark.centre - motion_.apply(place.centre)).dot(n);
            const Vec2 arm = mark.centre - motion_.about_mm - motion_.shift_mm;
            const Eigen::Vector3d row(n.x(), n.y(), cross(arm, n) / size_mm);
            normal += row * row.transpose();
            moment += row * off_mm;
            squares += off_mm * off_mm;
        }
        rms_mm = std::sqrt(squares / count);
        const Eigen::Vector3d step = normal.ldlt().solve(moment);
        motion_.shift_mm += step.head<2>();
        motion_.turn_rad += step.z() / size_mm;
    }
    misfit_mm_ = left_weight * rms_mm;
    for (const Mark& mark : marks)
        misfit_mm_ += (motion_.undo(mark.centre) - mark.centre).norm() / count;
}

Vec2 LentWay::place_at(double s_mm) const {
    const CurvePoint at = nominal_->evaluate(s_mm);
    return motion_.apply(at.position + ball_radius_mm_ * at.normal);
}

std::vector<SupposedPoint> LentWay::between(const Vec2& from, const Vec2& to) const {
    const double from_mm = nominal_->closest(motion_.undo(from)).s_mm;
    const double way_mm = nominal_->ahead(from_mm, nominal_->closest(motion_.undo(to)).s_mm);
    const Vec2 off_from = from - place_at(from_mm), off_to = to - place_at(from_mm + way_mm);
    std::vector<SupposedPoint> places;
    const double longest_mm = longest_step_share * nominal_->length();
    Vec2 last = from, normal = nominal_->evaluate(from_mm).normal;
    for (double gone_mm = 0.0, step_mm = longest_mm;;) {
        CurvePoint at = nominal_->evaluate(from_mm + gone_mm + step_mm);
        while (std::abs(turn_angle(normal, at.normal)) > most_step_turn_rad && step_mm > least_halving * longest_mm) {
            step_mm *= 0.5;
            at = nominal_->evaluate(from_mm + gone_mm + step_mm);
        }
        gone_mm += step_mm;
        step_mm = std::min(2.0 * step_mm, longest_mm);
        normal = at.normal;
        if (gone_mm >= way_mm) break;
        if (1.0 + ball_radius_mm_ * at.curvature < least_pace) continue;
        const double share = gone_mm / way_mm;
        const Vec2 place = place_at(from_mm + gone_mm) + (1.0 - share) * off_from + share * off_to;
        places.push_back({place, lent_sigma_share * (place - last).norm()});
        last = place;
    }
    // One right before the end says nothing that the point there does not.
    if (!places.empty() && (to - places.back().position).norm() < 2.0 * places.back().sigma_mm) places.pop_back();
    return places;
}

}  // namespace cmm::fitting
