// SPDX-License-Identifier: Apache-2.0
/// Six-point alignment against bodies whose contact with a ball is a formula: planes and spheres.
#include "fitting/six_points.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double ball_mm = 1.5;

Isometry3d motion(const Vector3d& shift_mm, const Vector3d& turn_deg) {
    Isometry3d out = Isometry3d::Identity();
    const Vector3d turn = turn_deg * (std::numbers::pi / 180.0);
    if (turn.norm() > 0.0) out.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    out.translation() = shift_mm;
    return out;
}

/// Three on the top, two in front, one on the left.
SixPoints three_two_one() {
    return {{{{10, 10, 30}, Vector3d::UnitZ()},
             {{90, 12, 30}, Vector3d::UnitZ()},
             {{50, 45, 30}, Vector3d::UnitZ()},
             {{15, 0, 20}, -Vector3d::UnitY()},
             {{85, 0, 18}, -Vector3d::UnitY()},
             {{0, 25, 15}, -Vector3d::UnitX()}}};
}

/// Directions that no two share, on a blade-like set.
SixPoints oblique() {
    return {{{{10, 3, 20}, Vector3d(0.10, 1.0, 0.05).normalized()},
             {{-14, 4, 22}, Vector3d(-0.25, 1.0, 0.08).normalized()},
             {{2, 6, 70}, Vector3d(0.02, 1.0, -0.06).normalized()},
             {{-21, 0, 25}, Vector3d(-1.0, 0.1, 0.1).normalized()},
             {{-19, 1, 72}, Vector3d(-1.0, -0.2, 0.05).normalized()},
             {{0, 2, 90}, Vector3d(0.05, 0.1, 1.0).normalized()}}};
}

/// The same set with the first three as middles between both sides of the blade, which face each other at some degrees.
SixPoints with_middles() {
    auto points = oblique();
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3d away = (Vector3d(0.1, -0.05, 0.12) - points[i].normal).normalized();
        points[i].opposite = DatumTouch{points[i].place_mm - (3.0 + static_cast<double>(i)) * points[i].normal, away};
    }
    return points;
}

/// A ball that is led down on each place along its direction, both where `believed` puts them, onto spheres that touch
/// the true part's places from inside. Radius 0: planes. `excess_mm`: each place lies so far out of where it should.
TouchCentres touch(const SixPoints& points, const Isometry3d& truth, const Isometry3d& believed, double radius_mm,
                   double excess_mm = 0.0) {
    TouchCentres centres;
    for (const auto& wanted : touches_of(points)) {
        const Vector3d down = -(believed.linear() * wanted.normal);
        const Vector3d from = believed * (wanted.place_mm + 20.0 * wanted.normal);
        const Vector3d place = truth * (wanted.place_mm + excess_mm * wanted.normal);
        const Vector3d normal = truth.linear() * wanted.normal;
        if (radius_mm == 0.0) {
            centres.push_back(from + down * ((place + ball_mm * normal - from).dot(normal) / down.dot(normal)));
            continue;
        }
        const Vector3d to_middle = place - radius_mm * normal - from;
        const double along = to_middle.dot(down), reach = radius_mm + ball_mm;
        centres.push_back(from + down * (along - std::sqrt(reach * reach - (to_middle - along * down).squaredNorm())));
    }
    return centres;
}

double farthest(const SixPoints& points, const Isometry3d& a, const Isometry3d& b) {
    double worst = 0.0;
    for (const auto& point : points)
        worst = std::max(worst, (a * point.place_mm - b * point.place_mm).norm());
    return worst;
}

TEST(SixPoints, OfPlanesTheMotionIsExactHoweverLarge) {
    for (const Vector3d& turn : {Vector3d(0.3, -0.2, 0.5), Vector3d(12, -8, 25), Vector3d(0, 0, 0)}) {
        const auto truth = motion({3.0, -2.0, 5.0}, turn);
        const auto centres = touch(three_two_one(), truth, Isometry3d::Identity(), 0.0);
        const auto found = solve_six_points(three_two_one(), centres, ball_mm, Isometry3d::Identity());
        ASSERT_TRUE(found) << found.error().text();
        EXPECT_LT(farthest(three_two_one(), *found, truth), 1e-11);
        EXPECT_LT((found->linear() - truth.linear()).norm(), 1e-12);
    }
}

TEST(SixPoints, ARoundBesideThePlaceErrsByTheSquareAndIsMendedByTheNext) {
    const auto truth = motion({0.6, 0.4, -0.35}, {0.4, 0.2, -0.3});
    SixPointOptions options;
    options.residual_mm = options.moved_mm = 1e-9;
    SixPointRounds rounds(oblique(), ball_mm, options);
    std::vector<double> error{farthest(oblique(), truth, Isometry3d::Identity())};
    bool done = false;
    while (!done) {
        const auto taken = rounds.take(touch(oblique(), truth, rounds.frame().machine_from_part, 8.0));
        ASSERT_TRUE(taken) << taken.error().text();
        done = *taken;
        error.push_back(farthest(oblique(), truth, rounds.frame().machine_from_part));
    }
    EXPECT_LT(error.back(), 1e-9);
    EXPECT_LE(rounds.frame().rounds, 5);
    EXPECT_GT(error[1], 1e-4) << "one round alone is not enough";
    // Curvature 1/8 mm: k e^2 / 2 at the touches, times how well they hold the part.
    const double hold = hold_of(oblique()).condition;
    for (std::size_t k = 1; k + 1 < error.size() && error[k] > 1e-5; ++k)
        EXPECT_LT(error[k + 1], hold * error[k] * error[k] / 8.0) << k;
    EXPECT_LT(rounds.frame().largest_residual_mm(), 1e-9);
}

TEST(SixPoints, ConditionNumberIsThatOfTheArrangement) {
    // Pairs at distances a, b, c from the middle: singular values sqrt 2 and sqrt 2 times a/L, b/L, c/L.
    const auto pairs = [](double a, double b, double c) {
        return SixPoints{{{{a, 0, 0}, Vector3d::UnitZ()},
                          {{-a, 0, 0}, Vector3d::UnitZ()},
                          {{0, b, 0}, Vector3d::UnitX()},
                          {{0, -b, 0}, Vector3d::UnitX()},
                          {{0, 0, c}, Vector3d::UnitY()},
                          {{0, 0, -c}, Vector3d::UnitY()}}};
    };
    EXPECT_NEAR(hold_of(pairs(7, 7, 7)).condition, 1.0, 1e-12);
    const double length = std::sqrt((4.0 + 9.0 + 64.0) / 3.0);
    EXPECT_NEAR(hold_of(pairs(2, 3, 8)).length_mm, length, 1e-12);
    EXPECT_NEAR(hold_of(pairs(2, 3, 8)).condition, (8.0 / length) / (2.0 / length), 1e-12);

    const double condition = hold_of(oblique()).condition;
    EXPECT_GT(condition, 2.0);
    auto elsewhere = oblique();
    const auto moved = motion({-340, 80, 1200}, {33, -71, 140});
    for (auto& point : elsewhere)
        point = {moved * point.place_mm / 25.4, moved.linear() * point.normal};  // inches, other axes and origin
    EXPECT_NEAR(hold_of(elsewhere).condition, condition, 1e-9 * condition);
}

TEST(SixPoints, WhatIsFreeIsNamed) {
    SixPoints tube;  // about z through x 5, y -3: turn about the axis and shift along it
    for (std::size_t i = 0; i < 6; ++i) {
        const double a = 1.1 * static_cast<double>(i);
        const Vector3d out(std::cos(a), std::sin(a), 0.0);
        tube[i] = {Vector3d(5, -3, 12.0 * static_cast<double>(i % 3)) + 8.0 * out, out};
    }
    const auto of_tube = hold_of(tube);
    ASSERT_EQ(of_tube.weak.size(), 2U);
    EXPECT_GT(of_tube.condition, 1e12);

    auto without_height = three_two_one();  // the tops now face the front: nothing says where z is
    without_height[0].normal = without_height[1].normal = without_height[2].normal = -Vector3d::UnitY();
    const auto shift = hold_of(without_height);
    ASSERT_FALSE(shift.weak.empty());

    auto one_line = three_two_one();  // the three tops on a line along x: free to turn about a line through them
    one_line[2].place_mm = {50, 11, 30};
    one_line[0].place_mm.y() = one_line[1].place_mm.y() = 11;
    const auto turn = hold_of(one_line);
    ASSERT_EQ(turn.weak.size(), 1U);
    EXPECT_GT(std::abs(turn.weak[0].axis.x()), 0.99);

    // A motion that is called free moves no place along its direction.
    for (const auto& [points, hold] :
         {std::pair{tube, of_tube}, std::pair{without_height, shift}, std::pair{one_line, turn}}) {
        for (const auto& weak : hold.weak) {
            for (const auto& point : points) {
                const Vector3d by =
                    weak.axis.isZero()
                        ? weak.shift
                        : Vector3d(weak.axis.cross(point.place_mm - weak.through_mm) + weak.pitch_mm * weak.axis);
                EXPECT_NEAR(by.dot(point.normal), 0.0, 1e-7);
            }
        }
    }
    const auto refused = require_hold(one_line);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, core::ErrorCode::config_invalid);
    EXPECT_NE(refused.error().message.find("free is a turn about the axis"), std::string::npos)
        << refused.error().message;
    EXPECT_TRUE(require_hold(three_two_one()));
    EXPECT_FALSE(require_hold(three_two_one(), 1.5));
}

/// Of `points` on spheres, against touches that scatter.
void expect_covariance_of_repeated_touches(const SixPoints& points) {
    const auto truth = motion({0.2, 0.1, -0.3}, {0.2, 0.3, -0.1});
    SixPointOptions options;
    options.touch_standard_mm = 0.002;
    options.residual_mm = options.moved_mm = 10.0;
    const auto exact = touch(points, truth, truth, 8.0);
    const auto touches = touches_of(points);
    Matrix6 sum = Matrix6::Zero(), stated = Matrix6::Zero();
    constexpr int trials = 4000;
    core::Rng rng(20);
    for (int k = 0; k < trials; ++k) {
        auto centres = exact;
        for (std::size_t i = 0; i < centres.size(); ++i)
            centres[i] += options.touch_standard_mm * rng.normal() * (truth.linear() * touches[i].normal);
        SixPointRounds rounds(points, ball_mm, options);
        ASSERT_TRUE(rounds.take(centres));
        const auto& frame = rounds.frame();
        stated = frame.covariance;
        // The part's own error motion: true places to where the frame takes them.
        const Isometry3d wrong = truth.inverse() * frame.machine_from_part;
        Eigen::Matrix<double, 6, 1> error;
        const Eigen::AngleAxisd turn(wrong.linear());
        error << wrong * frame.about_mm - frame.about_mm, turn.angle() * turn.axis();
        sum += error * error.transpose();
    }
    // Of 4000 a variance scatters by 2.2 %.
    for (Eigen::Index i = 0; i < 6; ++i) {
        EXPECT_NEAR(sum(i, i) / trials / stated(i, i), 1.0, 0.1) << i;
        for (Eigen::Index j = 0; j < i; ++j) {
            const double scale = std::sqrt(stated(i, i) * stated(j, j));
            EXPECT_NEAR((sum(i, j) / trials - stated(i, j)) / scale, 0.0, 0.1) << i << ' ' << j;
        }
    }
}

TEST(SixPoints, CovarianceIsThatOfRepeatedTouches) {
    expect_covariance_of_repeated_touches(oblique());
    expect_covariance_of_repeated_touches(with_middles());
}

TEST(SixPoints, AMiddleDoesNotMindHowThickThePartIs) {
    const auto truth = motion({0.6, 0.4, -0.35}, {0.4, 0.2, -0.3});
    auto points = with_middles();
    for (std::size_t i = 3; i < points.size(); ++i)
        points[i].opposite = DatumTouch{points[i].place_mm - 10.0 * points[i].normal, -points[i].normal};
    SixPointOptions options;
    options.residual_mm = options.moved_mm = 1e-9;
    for (const double excess_mm : {0.0, 0.2, -0.05}) {
        SixPointRounds rounds(points, ball_mm, options);
        for (bool done = false; !done;) {
            const auto taken =
                rounds.take(touch(points, truth, rounds.frame().machine_from_part, 8.0, 0.5 * excess_mm));
            ASSERT_TRUE(taken) << taken.error().text();
            done = *taken;
        }
        EXPECT_LT(farthest(points, truth, rounds.frame().machine_from_part), 1e-8) << excess_mm;
        for (const auto& found : rounds.frame().excess_mm) {
            ASSERT_TRUE(found);
            EXPECT_NEAR(*found, excess_mm, 1e-8);
        }
    }
    // A single touch takes half of it for a shift of the part.
    const auto taken = solve_six_points(oblique(), touch(oblique(), truth, truth, 8.0, 0.1), ball_mm, truth);
    ASSERT_TRUE(taken);
    EXPECT_GT(farthest(oblique(), truth, *taken), 0.09);
}

TEST(SixPoints, AMiddleHoldsAsATouchInItsPlace) {
    auto middles = three_two_one();
    for (auto& point : middles) {
        point.opposite = DatumTouch{point.place_mm - 4.0 * point.normal, -point.normal};
        point.place_mm += 4.0 * point.normal;
    }
    EXPECT_NEAR(hold_of(middles).condition, hold_of(three_two_one()).condition, 1e-12);
    EXPECT_NEAR(hold_of(middles).length_mm, hold_of(three_two_one()).length_mm, 1e-12);
}

TEST(SixPoints, WhatDoesNotSettleSaysWhere) {
    SixPointOptions options;
    options.most_rounds = 4;
    SixPointRounds rounds(three_two_one(), ball_mm, options);
    core::Result<bool> taken = false;
    for (int k = 0; k < options.most_rounds; ++k) {
        ASSERT_TRUE(taken);
        ASSERT_FALSE(*taken);
        auto centres = touch(three_two_one(), Isometry3d::Identity(), Isometry3d::Identity(), 0.0);
        centres[4].y() += k % 2 == 0 ? 0.1 : -0.1;  // a datum that is loose
        taken = rounds.take(centres);
    }
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error().code, core::ErrorCode::fit_not_evaluable);
    EXPECT_NE(taken.error().message.find("datum point 5"), std::string::npos) << taken.error().message;
    EXPECT_NE(taken.error().message.find("4 rounds"), std::string::npos) << taken.error().message;
}

TEST(SixPoints, CentresThatFitNoPositionAreAnError) {
    auto centres = touch(three_two_one(), Isometry3d::Identity(), Isometry3d::Identity(), 0.0);
    centres[0].x() = std::nan("");
    EXPECT_FALSE(solve_six_points(three_two_one(), centres, ball_mm, Isometry3d::Identity()));
}

}  // namespace
}  // namespace cmm::fitting
