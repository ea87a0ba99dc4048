// SPDX-License-Identifier: Apache-2.0
#include "fitting/six_points.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"

namespace cmm::fitting {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int most_newton_steps = 50;
constexpr double newton_end = 1e-13;    // shift in units of the set's size, and turn
constexpr double smallest_turn = 1e-6;  // of a unit motion, below which it is a shift

Vector3d middle_of(const SixCentres& places) {
    Vector3d sum = Vector3d::Zero();
    for (const auto& place : places)
        sum += place;
    return sum / static_cast<double>(places.size());
}

double size_about(const SixCentres& places, const Vector3d& middle) {
    double sum = 0.0;
    for (const auto& place : places)
        sum += (place - middle).squaredNorm();
    return std::sqrt(sum / static_cast<double>(places.size()));
}

SixCentres places_of(const SixPoints& points) {
    SixCentres places;
    std::transform(points.begin(), points.end(), places.begin(), [](const DatumPoint& p) { return p.place_mm; });
    return places;
}

/// n . (t + w x (q - c)) = n . t + ((q - c) x n) . w, the second for w times `length_mm`.
Matrix6 rows_at(const SixPoints& points, const SixCentres& at, const Vector3d& about, double length_mm) {
    Matrix6 rows;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vector3d& n = points[i].normal;
        rows.row(static_cast<Eigen::Index>(i)) << n.transpose(), (at[i] - about).cross(n).transpose() / length_mm;
    }
    return rows;
}

FreeMotion free_motion(const Vector6& motion, const SixPointHold& hold) {
    const Vector3d shift = motion.head<3>(), turn = motion.tail<3>();  // both in units of length
    FreeMotion out;
    if (turn.norm() < smallest_turn * motion.norm()) {
        out.shift = shift.normalized();
        return out;
    }
    // Of a screw the axis runs through c + w x t / w^2.
    const Vector3d w = turn / hold.length_mm;
    out.axis = w.normalized();
    out.through_mm = hold.middle_mm + w.cross(shift) / w.squaredNorm();
    out.pitch_mm = shift.dot(w) / w.squaredNorm();
    return out;
}

std::string vector_text(const Vector3d& v, int digits) {
    return "(" + core::fixed(v.x(), digits) + ", " + core::fixed(v.y(), digits) + ", " + core::fixed(v.z(), digits) +
           ")";
}

Isometry3d moved_by(const Vector6& motion, const Vector3d& about) {
    const Vector3d turn = motion.tail<3>();
    const double angle = turn.norm();
    Isometry3d out = Isometry3d::Identity();
    if (angle > 0.0) out.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    out.translation() = about + motion.head<3>() - out.linear() * about;
    return out;
}

SixCentres in_part(const SixCentres& centres, const Isometry3d& machine_from_part) {
    const Isometry3d part_from_machine = machine_from_part.inverse();
    SixCentres out;
    std::transform(centres.begin(), centres.end(), out.begin(),
                   [&](const Vector3d& centre) { return Vector3d(part_from_machine * centre); });
    return out;
}

}  // namespace

SixPointHold hold_of(const SixPoints& points, double largest_condition) {
    SixPointHold hold;
    const SixCentres places = places_of(points);
    hold.middle_mm = middle_of(places);
    // Six times the same place: the directions alone count, and no turn is held.
    const double size_mm = size_about(places, hold.middle_mm);
    hold.length_mm = size_mm > 0.0 ? size_mm : 1.0;
    const Eigen::JacobiSVD<Matrix6> svd(rows_at(points, places, hold.middle_mm, hold.length_mm), Eigen::ComputeFullV);
    const Vector6& felt = svd.singularValues();
    const double noise = 6.0 * std::numeric_limits<double>::epsilon() * felt[0];
    hold.condition = felt[5] > noise ? felt[0] / felt[5] : std::numeric_limits<double>::infinity();
    for (Eigen::Index k = 5; k >= 0 && felt[k] * largest_condition < felt[0]; --k)
        hold.weak.push_back(free_motion(svd.matrixV().col(k), hold));
    return hold;
}

Matrix6 motion_by_touches(const SixPoints& points) {
    const SixCentres places = places_of(points);
    return rows_at(points, places, middle_of(places), 1.0).inverse();
}

std::string weak_words(const SixPointHold& hold) {
    std::string out = "the six datum points do not hold the part: condition number ";
    out += std::isfinite(hold.condition) ? core::fixed(hold.condition, 0) : std::string("infinite");
    for (std::size_t k = 0; k < hold.weak.size(); ++k) {
        const FreeMotion& motion = hold.weak[k];
        out += k == 0 ? "; free is " : " and ";
        if (motion.axis.isZero()) {
            out += "a shift along " + vector_text(motion.shift, 2);
            continue;
        }
        out += "a turn about the axis " + vector_text(motion.axis, 2) + " through " +
               vector_text(motion.through_mm, 1) + " mm";
        if (std::abs(motion.pitch_mm) > 0.05) out += " with a shift along it";
    }
    return out;
}

core::Status require_hold(const SixPoints& points, double largest_condition) {
    const auto hold = hold_of(points, largest_condition);
    if (hold.weak.empty()) return {};
    return core::fail(core::ErrorCode::config_invalid,
                      weak_words(hold) + " (at most " + core::fixed(largest_condition, 0) + " is allowed)");
}

std::array<double, datum_points> six_residuals(const SixPoints& points, const SixCentres& centres_mm,
                                               double ball_radius_mm, const Isometry3d& machine_from_part) {
    const SixCentres at = in_part(centres_mm, machine_from_part);
    std::array<double, datum_points> out{};
    for (std::size_t i = 0; i < points.size(); ++i)
        out[i] = points[i].normal.dot(at[i] - points[i].place_mm) - ball_radius_mm;
    return out;
}

core::Result<Isometry3d> solve_six_points(const SixPoints& points, const SixCentres& centres_mm, double ball_radius_mm,
                                          const Isometry3d& start) {
    const auto hold = hold_of(points);
    Isometry3d motion = start;
    for (int step = 0; step < most_newton_steps; ++step) {
        const auto off = six_residuals(points, centres_mm, ball_radius_mm, motion);
        const SixCentres at = in_part(centres_mm, motion);
        const Eigen::FullPivLU<Matrix6> rows(rows_at(points, at, hold.middle_mm, hold.length_mm));
        if (!rows.isInvertible()) break;
        // Moving the part by x moves the ball in its frame the other way: the residual falls by row . x.
        Vector6 x = rows.solve(Eigen::Map<const Vector6>(off.data()));
        const double size = std::max(x.head<3>().norm() / hold.length_mm, x.tail<3>().norm() / hold.length_mm);
        if (!std::isfinite(size)) break;
        x.tail<3>() /= hold.length_mm;
        motion = motion * moved_by(x, hold.middle_mm);
        if (size > newton_end) continue;
        // Products of many rotations drift off orthogonality by rounding.
        motion.linear() = Eigen::Quaterniond(motion.linear()).normalized().toRotationMatrix();
        return motion;
    }
    return core::fail(core::ErrorCode::fit_not_evaluable, "no position of the part fits the six touches");
}

Vector3d SixPointFrame::turn_rad() const {
    const Eigen::AngleAxisd turn(machine_from_part.linear());
    return turn.angle() * turn.axis();
}

std::array<double, 6> SixPointFrame::standard() const {
    std::array<double, 6> out{};
    for (std::size_t k = 0; k < out.size(); ++k) {
        const auto at = static_cast<Eigen::Index>(k);
        out[k] = std::sqrt(std::max(0.0, covariance(at, at) + shared(at, at)));
    }
    return out;
}

double SixPointFrame::largest_residual_mm() const {
    double largest = 0.0;
    for (const double residual : residual_mm)
        largest = std::max(largest, std::abs(residual));
    return largest;
}

SixPointRounds::SixPointRounds(const SixPoints& points, double ball_radius_mm, const SixPointOptions& options)
    : points_(points), ball_radius_mm_(ball_radius_mm), options_(options) {
    const auto hold = hold_of(points);
    frame_.about_mm = hold.middle_mm;
    frame_.condition = hold.condition;
    frame_.length_mm = hold.length_mm;
    frame_.touch_standard_mm = options.touch_standard_mm;
    frame_.points = points;
}

core::Result<bool> SixPointRounds::take(const SixCentres& centres_mm) {
    const Isometry3d before = frame_.machine_from_part;
    frame_.residual_mm = six_residuals(points_, centres_mm, ball_radius_mm_, before);
    const auto found = solve_six_points(points_, centres_mm, ball_radius_mm_, before);
    if (!found) return tl::unexpected(found.error());
    frame_.machine_from_part = *found;
    frame_.moved_mm = 0.0;
    for (const auto& point : points_)
        frame_.moved_mm = std::max(frame_.moved_mm, (*found * point.place_mm - before * point.place_mm).norm());
    const Matrix6 inverse = rows_at(points_, in_part(centres_mm, *found), frame_.about_mm, 1.0).inverse();
    frame_.covariance = options_.touch_standard_mm * options_.touch_standard_mm * inverse * inverse.transpose();
    ++frame_.rounds;
    if (frame_.largest_residual_mm() <= options_.residual_mm && frame_.moved_mm <= options_.moved_mm) return true;
    if (frame_.rounds < options_.most_rounds) return false;
    return tl::unexpected(not_converged());
}

core::Error SixPointRounds::not_converged() const {
    std::size_t worst = 0;
    for (std::size_t i = 1; i < datum_points; ++i)
        if (std::abs(frame_.residual_mm[i]) > std::abs(frame_.residual_mm[worst])) worst = i;
    return {core::ErrorCode::fit_not_evaluable,
            "the six-point alignment does not settle in " + std::to_string(frame_.rounds) + " rounds: datum point " +
                std::to_string(worst + 1) + " was touched " + core::length_text(std::abs(frame_.residual_mm[worst])) +
                " off (at most " + core::length_text(options_.residual_mm) + " is asked for), the places moved by " +
                core::length_text(frame_.moved_mm) + " (" + core::length_text(options_.moved_mm) + ")",
            {},
            core::Motion::not_concerned};
}

}  // namespace cmm::fitting
