// SPDX-License-Identifier: Apache-2.0
#include "fitting/six_points.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::fitting {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int most_newton_steps = 50;
constexpr double newton_end = 1e-13;    // shift in units of the set's size, and turn
constexpr double smallest_turn = 1e-6;  // of a unit motion, below which it is a shift

using Places = std::array<Vector3d, datum_points>;

Vector3d middle_of(const Places& places) {
    Vector3d sum = Vector3d::Zero();
    for (const auto& place : places)
        sum += place;
    return sum / static_cast<double>(places.size());
}

double size_about(const Places& places, const Vector3d& middle) {
    double sum = 0.0;
    for (const auto& place : places)
        sum += (place - middle).squaredNorm();
    return std::sqrt(sum / static_cast<double>(places.size()));
}

Places places_of(const SixPoints& points) {
    Places places;
    std::transform(points.begin(), points.end(), places.begin(), [](const DatumPoint& p) { return p.middle_mm(); });
    return places;
}

/// What the touches of each datum say together: of a middle half the difference of its two.
template <class Said>
void for_each_datum(const SixPoints& points, const std::vector<Said>& touched, const auto& take) {
    std::size_t touch = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Said& first = touched[touch++];
        if (points[i].opposite)
            take(i, Said(0.5 * (first - touched[touch++])));
        else
            take(i, first);
    }
}

/// n . (t + w x (q - c)) = n . t + ((q - c) x n) . w, the second for w times `length_mm`.
Matrix6 rows_at(const SixPoints& points, const TouchCentres& at, const Vector3d& about, double length_mm) {
    const auto touches = touches_of(points);
    std::vector<Vector6> of_touch(touches.size());
    for (std::size_t i = 0; i < touches.size(); ++i)
        of_touch[i] << touches[i].normal, (at[i] - about).cross(touches[i].normal) / length_mm;
    Matrix6 rows;
    for_each_datum(points, of_touch, [&](std::size_t i, const Vector6& row) {
        rows.row(static_cast<Eigen::Index>(i)) = row.transpose();
    });
    return rows;
}

/// How far each ball lies off its place along its direction.
std::vector<double> off_places(const SixPoints& points, const TouchCentres& at, double ball_radius_mm) {
    const auto touches = touches_of(points);
    std::vector<double> off(touches.size());
    for (std::size_t i = 0; i < touches.size(); ++i)
        off[i] = touches[i].normal.dot(at[i] - touches[i].place_mm) - ball_radius_mm;
    return off;
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

TouchCentres in_part(const TouchCentres& centres, const Isometry3d& machine_from_part) {
    const Isometry3d part_from_machine = machine_from_part.inverse();
    TouchCentres out;
    std::transform(centres.begin(), centres.end(), std::back_inserter(out),
                   [&](const Vector3d& centre) { return Vector3d(part_from_machine * centre); });
    return out;
}

}  // namespace

std::vector<DatumTouch> touches_of(const SixPoints& points) {
    std::vector<DatumTouch> touches;
    for (const auto& point : points) {
        touches.push_back({point.place_mm, point.normal});
        if (point.opposite) touches.push_back(*point.opposite);
    }
    return touches;
}

SixPointHold hold_of(const SixPoints& points, double largest_condition) {
    SixPointHold hold;
    const Places places = places_of(points);
    TouchCentres touched;
    for (const auto& touch : touches_of(points))
        touched.push_back(touch.place_mm);
    hold.middle_mm = middle_of(places);
    // Six times the same place: the directions alone count, and no turn is held.
    const double size_mm = size_about(places, hold.middle_mm);
    hold.length_mm = size_mm > 0.0 ? size_mm : 1.0;
    const Eigen::JacobiSVD<Matrix6> svd(rows_at(points, touched, hold.middle_mm, hold.length_mm), Eigen::ComputeFullV);
    const Vector6& felt = svd.singularValues();
    const double noise = 6.0 * std::numeric_limits<double>::epsilon() * felt[0];
    hold.condition = felt[5] > noise ? felt[0] / felt[5] : std::numeric_limits<double>::infinity();
    for (Eigen::Index k = 5; k >= 0 && felt[k] * largest_condition < felt[0]; --k)
        hold.weak.push_back(free_motion(svd.matrixV().col(k), hold));
    return hold;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> motion_by_touches(const SixPoints& points) {
    const auto touches = touches_of(points);
    TouchCentres places;
    for (const auto& touch : touches)
        places.push_back(touch.place_mm);
    const Matrix6 by_datum = rows_at(points, places, middle_of(places_of(points)), 1.0).inverse();
    Eigen::Matrix<double, 6, Eigen::Dynamic> motion(6, static_cast<Eigen::Index>(touches.size()));
    Eigen::Index touch = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto datum = by_datum.col(static_cast<Eigen::Index>(i));
        motion.col(touch++) = points[i].opposite ? Vector6(0.5 * datum) : Vector6(datum);
        if (points[i].opposite) motion.col(touch++) = -0.5 * datum;
    }
    return motion;
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
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!points[i].opposite) continue;
        const double angle = std::acos(std::clamp(points[i].normal.dot(points[i].opposite->normal), -1.0, 1.0));
        if (angle >= smallest_opposition_rad) continue;
        return core::fail(core::ErrorCode::config_invalid,
                          "datum point " + std::to_string(i + 1) +
                              " has no middle: its two touches face away from each other by " +
                              core::fixed(core::deg_from_rad(angle), 0) + " degrees (" +
                              core::fixed(core::deg_from_rad(smallest_opposition_rad), 0) + " at least)");
    }
    const auto hold = hold_of(points, largest_condition);
    if (hold.weak.empty()) return {};
    return core::fail(core::ErrorCode::config_invalid,
                      weak_words(hold) + " (at most " + core::fixed(largest_condition, 0) + " is allowed)");
}

std::array<double, datum_points> six_residuals(const SixPoints& points, const TouchCentres& centres_mm,
                                               double ball_radius_mm, const Isometry3d& machine_from_part) {
    std::array<double, datum_points> out{};
    for_each_datum(points, off_places(points, in_part(centres_mm, machine_from_part), ball_radius_mm),
                   [&](std::size_t i, double off) { out[i] = off; });
    return out;
}

std::array<std::optional<double>, datum_points> six_excesses(const SixPoints& points, const TouchCentres& centres_mm,
                                                             double ball_radius_mm,
                                                             const Isometry3d& machine_from_part) {
    const auto off = off_places(points, in_part(centres_mm, machine_from_part), ball_radius_mm);
    std::array<std::optional<double>, datum_points> out{};
    std::size_t touch = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (points[i].opposite) out[i] = off[touch] + off[touch + 1];
        touch += points[i].opposite ? 2 : 1;
    }
    return out;
}

core::Result<Isometry3d> solve_six_points(const SixPoints& points, const TouchCentres& centres_mm,
                                          double ball_radius_mm, const Isometry3d& start) {
    const auto hold = hold_of(points);
    Isometry3d motion = start;
    for (int step = 0; step < most_newton_steps; ++step) {
        const auto off = six_residuals(points, centres_mm, ball_radius_mm, motion);
        const TouchCentres at = in_part(centres_mm, motion);
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

core::Result<bool> SixPointRounds::take(const TouchCentres& centres_mm) {
    const Isometry3d before = frame_.machine_from_part;
    frame_.residual_mm = six_residuals(points_, centres_mm, ball_radius_mm_, before);
    const auto found = solve_six_points(points_, centres_mm, ball_radius_mm_, before);
    if (!found) return tl::unexpected(found.error());
    frame_.machine_from_part = *found;
    frame_.moved_mm = 0.0;
    for (const auto& touch : touches_of(points_))
        frame_.moved_mm = std::max(frame_.moved_mm, (*found * touch.place_mm - before * touch.place_mm).norm());
    frame_.excess_mm = six_excesses(points_, centres_mm, ball_radius_mm_, *found);
    const Matrix6 inverse = rows_at(points_, in_part(centres_mm, *found), frame_.about_mm, 1.0).inverse();
    frame_.covariance = inverse * touch_variances().asDiagonal() * inverse.transpose();
    ++frame_.rounds;
    if (frame_.largest_residual_mm() <= options_.residual_mm && frame_.moved_mm <= options_.moved_mm) return true;
    if (frame_.rounds < options_.most_rounds) return false;
    return tl::unexpected(not_converged());
}

/// Of what each datum says; half of one touch's where two say it.
Eigen::Matrix<double, 6, 1> SixPointRounds::touch_variances() const {
    Vector6 variances;
    for (std::size_t i = 0; i < points_.size(); ++i)
        variances[static_cast<Eigen::Index>(i)] =
            options_.touch_standard_mm * options_.touch_standard_mm * (points_[i].opposite ? 0.5 : 1.0);
    return variances;
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
