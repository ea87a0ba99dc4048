// SPDX-License-Identifier: Apache-2.0
/// Best fits against formulas, brute force and published approximations.
#include "fitting/best_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "fitting/chebyshev.hpp"
#include "support/section_truth.hpp"

namespace cmm::fitting {
namespace {

using section_truth::ExactSection;

constexpr double place_limit_mm = 1e-4, turn_limit_rad = 1e-6;
constexpr std::array objectives{FitObjective::least_squares, FitObjective::min_max, FitObjective::into_tolerance};

ExactSection blade(std::uint64_t seed) {
    return section_truth::of_family(families::make(families::Family::compressor, seed));
}

ClosedCurve curve_of(const ExactSection& section) {
    std::vector<Vec2> points;
    for (int k = 0; k < 6000; ++k)
        points.push_back(section.at(k * (4.0 / 6000)).position);
    return ClosedCurve::through(points).value();
}

Zone zone_of(double t) {
    constexpr std::array zones{Zone::le, Zone::pressure, Zone::te, Zone::suction};
    return zones[static_cast<std::size_t>(t) % 4];
}

/// A contour that is the section with `bump(t)` of material more, moved.
template <class Bump>
std::vector<ContourPoint> contour_of(const ExactSection& section, const PlaneMotion& motion, Bump bump, int count) {
    std::vector<ContourPoint> contour;
    double s = 0.0;
    for (int k = 0; k < count; ++k) {
        const double t = 4.0 * k / count;
        const auto jet = section.at(t);
        ContourPoint point;
        point.normal = motion.apply_to_direction(jet.normal());
        point.position_mm = motion.apply(jet.position) + bump(t) * point.normal;
        if (k > 0) s += (point.position_mm - contour.back().position_mm).norm();
        point.arc_length_mm = s;
        point.zone = zone_of(t);
        contour.push_back(point);
    }
    return contour;
}

double no_bump(double) {
    return 0.0;
}

/// About `nominal`'s own centre, as the fit's motion is.
PlaneMotion motion_about_centre(const ExactSection& nominal, const Vec2& shift, double turn) {
    PlaneMotion motion;
    motion.about_mm = section_truth::SectionTruth(nominal).centroid();
    motion.shift_mm = shift;
    motion.turn_rad = turn;
    return motion;
}

TEST(Chebyshev, ALineThroughTheExponentialFunction) {
    // Best uniform approximation of exp on [0, 1] by a line, by hand: it touches where exp' = e - 1.
    const int n = 100001;
    Eigen::MatrixXd rows(n, 2);
    Eigen::VectorXd r(n);
    for (int i = 0; i < n; ++i) {
        const double x = i / (n - 1.0);
        rows.row(i) << 1.0, x;
        r[i] = std::exp(x);
    }
    const auto fit = chebyshev_fit(rows, r);
    ASSERT_TRUE(fit) << fit.error().message;
    const double slope = std::numbers::e - 1.0;
    EXPECT_NEAR(fit->x[1], slope, 1e-9);
    EXPECT_NEAR(fit->x[0], 0.5 * (std::numbers::e - slope * std::log(slope)), 1e-9);
    EXPECT_NEAR(fit->level, 0.5 * (2.0 - std::numbers::e + slope * std::log(slope)), 1e-9);
    EXPECT_EQ(fit->active.size(), 3u);
}

TEST(Chebyshev, APolynomialOfChebyshev) {
    // x^3 less its best parabola on [-1, 1] is T3/4.
    const int n = 20001;
    Eigen::MatrixXd rows(n, 3);
    Eigen::VectorXd r(n);
    for (int i = 0; i < n; ++i) {
        const double x = 2.0 * i / (n - 1.0) - 1.0;
        rows.row(i) << 1.0, x, x * x;
        r[i] = x * x * x;
    }
    const auto fit = chebyshev_fit(rows, r);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_NEAR(fit->level, 0.25, 1e-8);
    EXPECT_NEAR(fit->x[0], 0.0, 1e-8);
    EXPECT_NEAR(fit->x[1], 0.75, 1e-8);
    EXPECT_NEAR(fit->x[2], 0.0, 1e-8);
    EXPECT_FALSE(chebyshev_fit(Eigen::MatrixXd::Ones(9, 2), Eigen::VectorXd::Ones(9)));
}

TEST(BestFit, APerturbedNominalIsFoundBack) {
    for (const auto objective : objectives) {
        for (const double size : {0.1, 1.0, 3.0}) {
            const auto section = blade(4);
            const auto put = motion_about_centre(section, size * Vec2(0.06, -0.09), size * 0.006);
            const auto contour = contour_of(section, put, no_bump, 2400);
            const auto nominal = curve_of(section);
            BestFitOptions options;
            options.objective = objective;
            const auto found = fit_to_nominal(ContourGeometry(contour), nominal, options);
            ASSERT_TRUE(found) << to_string(objective) << ": " << found.error().message;
            EXPECT_NEAR(found->motion.turn_rad, put.turn_rad, turn_limit_rad) << to_string(objective);
            // The fit turns about its own centre, which is that of 400 points.
            const Vec2 there = found->motion.apply(put.about_mm) - put.apply(put.about_mm);
            EXPECT_LT(there.norm(), place_limit_mm) << to_string(objective);
            EXPECT_LT(found->largest_mm, place_limit_mm) << to_string(objective);
            EXPECT_GT(found->condition, 1.0);
        }
    }
}

/// From far off some feet begin on the other side or beyond an edge: the fit must not stay with them.
TEST(BestFit, FromFarOffItIsThatFromNearby) {
    const auto bump = [](double t) {
        return 0.012 * std::cos(std::numbers::pi * t) + 0.008 * std::cos(2.5 * std::numbers::pi * t + 1.9) +
               0.015 * std::exp(-150.0 * (t - 1.2) * (t - 1.2));
    };
    for (const std::uint64_t seed : {4u, 9u, 14u}) {
        const auto section = blade(seed);
        const auto nominal = curve_of(section);
        const auto near = motion_about_centre(section, {0.0, 0.0}, 0.0);
        const auto far = motion_about_centre(section, {3.0, -4.0}, 20.0 * std::numbers::pi / 180.0);
        const auto contour_near = contour_of(section, near, bump, 2400);
        const auto contour_far = contour_of(section, far, bump, 2400);
        for (const auto objective : objectives)
            for (const bool sides_only : {false, true}) {
                BestFitOptions options;
                options.objective = objective;
                if (sides_only) options.zones = {false, true, false, true};
                options.tolerance = {ToleranceZone{0.0, 0.03}, {0.0, 0.05}, {0.0, 0.03}, {0.0, 0.05}};
                const auto here = fit_to_nominal(ContourGeometry(contour_near), nominal, options);
                const auto there = fit_to_nominal(ContourGeometry(contour_far), nominal, options);
                ASSERT_TRUE(here) << to_string(objective) << ": " << here.error().message;
                ASSERT_TRUE(there) << to_string(objective) << ": " << there.error().message;
                const bool squares = objective == FitObjective::least_squares;
                const double before = squares ? here->rms_mm : here->largest_mm;
                const double after = squares ? there->rms_mm : there->largest_mm;
                if (objective != FitObjective::into_tolerance) {
                    EXPECT_NEAR(after, before, 1e-6) << seed << " " << sides_only;
                }
                EXPECT_NEAR(there->motion.turn_rad - far.turn_rad, here->motion.turn_rad, 2e-6)
                    << to_string(objective) << " " << seed << " " << sides_only;
            }
    }
}

TEST(BestFit, SeveralSectionsMoveAsOneBody) {
    const std::array sections{blade(4), blade(5), blade(6)};
    PlaneMotion put;
    put.about_mm = {3.0, -4.0};
    put.shift_mm = {0.11, -0.04};
    put.turn_rad = 0.004;
    std::vector<std::vector<ContourPoint>> contours;
    std::vector<ContourGeometry> geometries;
    std::vector<ClosedCurve> nominals;
    for (const auto& section : sections) {
        contours.push_back(contour_of(section, put, no_bump, 2400));
        nominals.push_back(curve_of(section));
    }
    std::vector<FitMember> members;
    for (const auto& contour : contours)
        geometries.emplace_back(contour);
    for (std::size_t k = 0; k < 3; ++k)
        members.push_back({&geometries[k], &nominals[k], {}});
    for (const auto objective : objectives) {
        BestFitOptions options;
        options.objective = objective;
        const auto found = fit_to_nominals(members, options);
        ASSERT_TRUE(found) << found.error().message;
        EXPECT_NEAR(found->motion.turn_rad, put.turn_rad, turn_limit_rad);
        EXPECT_LT((found->motion.apply(put.about_mm) - put.apply(put.about_mm)).norm(), place_limit_mm);
        EXPECT_EQ(found->slopes.size(), 3u);
    }
}

TEST(BestFit, WhatIsFixedStaysAtZero) {
    const auto section = blade(7);
    const auto nominal = curve_of(section);
    const auto put = motion_about_centre(section, {0.06, -0.09}, 0.004);
    const auto contour = contour_of(section, put, no_bump, 2400);
    for (const auto objective : objectives) {
        double all_free = 0.0;
        for (const int held : {0, 1, 2, 4, 5, 6, 3}) {
            BestFitOptions options;
            options.objective = objective;
            options.translate_x = (held & 1) == 0;
            options.translate_y = (held & 2) == 0;
            options.rotate = (held & 4) == 0;
            const auto found = fit_to_nominal(ContourGeometry(contour), nominal, options);
            ASSERT_TRUE(found) << held << ": " << found.error().message;
            EXPECT_EQ(found->motion.shift_mm.x() == 0.0, !options.translate_x);
            EXPECT_EQ(found->motion.shift_mm.y() == 0.0, !options.translate_y);
            EXPECT_EQ(found->motion.turn_rad == 0.0, !options.rotate);
            if (held == 0) {
                all_free = found->rms_mm;
            } else {
                EXPECT_GT(found->rms_mm, 10.0 * all_free + place_limit_mm);
            }
        }
        BestFitOptions nothing;
        nothing.translate_x = nothing.translate_y = nothing.rotate = false;
        const auto refused = fit_to_nominal(ContourGeometry(contour), nominal, nothing);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, core::ErrorCode::usage);
    }
}

/// The distance of a moved contour's point to the section by Newton's method on the formula, from where it was made.
class Formula {
  public:
    Formula(const ExactSection& section, std::span<const ContourPoint> contour)
        : section_(section), contour_(contour) {}

    double largest(const Eigen::Vector3d& motion, const Vec2& about, double middle = 0.0) const {
        PlaneMotion placed;
        placed.about_mm = about;
        placed.shift_mm = motion.head<2>();
        placed.turn_rad = motion[2];
        double largest = 0.0;
        for (std::size_t i = 0; i < contour_.size(); ++i) {
            const Vec2 p = placed.undo(contour_[i].position_mm);
            double t = 4.0 * static_cast<double>(i) / static_cast<double>(contour_.size());
            for (int round = 0; round < 8; ++round) {
                const auto jet = section_.at(std::fmod(t + 4.0, 4.0));
                const Vec2 off = p - jet.position;
                t += off.dot(jet.d1) / (jet.d1.squaredNorm() - off.dot(jet.d2));
            }
            const auto jet = section_.at(std::fmod(t + 4.0, 4.0));
            largest = std::max(largest, std::abs((p - jet.position).dot(jet.normal()) - middle));
        }
        return largest;
    }

    /// Brute force: the simplex of Nelder and Mead, started again until nothing gets better.
    Eigen::Vector3d smallest(Eigen::Vector3d at, const Vec2& about, double middle = 0.0) const {
        const auto f = [&](const Eigen::Vector3d& m) { return largest(m, about, middle); };
        double best = f(at);
        for (double size = 2e-2; size > 1e-7; size *= 0.5) {
            std::array<std::pair<double, Eigen::Vector3d>, 4> simplex;
            simplex[0] = {best, at};
            for (int k = 0; k < 3; ++k) {
                Eigen::Vector3d corner = at;
                corner[k] += k == 2 ? size / 20.0 : size;
                simplex[static_cast<std::size_t>(k) + 1] = {f(corner), corner};
            }
            for (int step = 0; step < 60; ++step) {
                std::sort(simplex.begin(), simplex.end(),
                          [](const auto& a, const auto& b) { return a.first < b.first; });
                const Eigen::Vector3d middle_of = (simplex[0].second + simplex[1].second + simplex[2].second) / 3.0;
                const auto along = [&](double by) {
                    const Eigen::Vector3d m = middle_of + by * (simplex[3].second - middle_of);
                    return std::pair(f(m), m);
                };
                auto tried = along(-1.0);
                if (tried.first < simplex[0].first) {
                    if (const auto farther = along(-2.0); farther.first < tried.first) tried = farther;
                } else if (tried.first >= simplex[2].first) {
                    tried = along(tried.first < simplex[3].first ? -0.5 : 0.5);
                }
                if (tried.first < simplex[3].first) {
                    simplex[3] = tried;
                } else {
                    for (std::size_t k = 1; k < 4; ++k) {
                        simplex[k].second = 0.5 * (simplex[0].second + simplex[k].second);
                        simplex[k].first = f(simplex[k].second);
                    }
                }
            }
            at = simplex[0].second;
            best = simplex[0].first;
        }
        return at;
    }

  private:
    const ExactSection& section_;
    std::span<const ContourPoint> contour_;
};

TEST(BestFit, TheSmallestLargestDeviationIsThatOfBruteForce) {
    for (const std::uint64_t seed : {4u, 9u}) {
        const auto section = blade(seed);
        const auto nominal = curve_of(section);
        const auto put = motion_about_centre(section, {0.03, 0.05}, -0.003);
        const auto bump = [](double t) {
            return 0.02 * std::sin(1.7 * t) + 0.011 * std::cos(5.1 * t + 1.0) +
                   0.03 * std::exp(-20.0 * (t - 1.4) * (t - 1.4));
        };
        const auto contour = contour_of(section, put, bump, 300);
        BestFitOptions options;
        options.objective = FitObjective::min_max;
        const auto found = fit_to_nominal(ContourGeometry(contour), nominal, options);
        ASSERT_TRUE(found) << found.error().message;
        const Formula formula(section, contour);
        const Vec2 about = found->motion.about_mm;
        const Eigen::Vector3d brute = formula.smallest({put.shift_mm.x(), put.shift_mm.y(), put.turn_rad}, about);
        const double smallest = formula.largest(brute, about);
        EXPECT_NEAR(found->largest_mm, smallest, 2e-5);
        const auto& m = found->motion;
        // The spline through the nominal's points is off by a nanometre or two where the formula's curvature jumps.
        EXPECT_NEAR(formula.largest({m.shift_mm.x(), m.shift_mm.y(), m.turn_rad}, about), found->largest_mm, 5e-6);
        const auto squares = fit_to_nominal(ContourGeometry(contour), nominal);
        ASSERT_TRUE(squares);
        EXPECT_GT(squares->largest_mm, found->largest_mm + 1e-3);
        EXPECT_LT(squares->rms_mm, found->rms_mm);
    }
}

TEST(BestFit, AThickBladeLiesInTheMiddleOfAZoneThatIsOffset) {
    // 30 um too thick all round, zone from -10 to +70 um: nothing has to move.
    const auto section = blade(8);
    const auto nominal = curve_of(section);
    const auto put = motion_about_centre(section, {0.02, -0.05}, 0.002);
    const auto contour = contour_of(
        section, put, [](double) { return 0.03; }, 2400);
    for (const auto objective : objectives) {
        BestFitOptions options;
        options.objective = objective;
        options.tolerance.fill({0.03, 0.04});
        const auto found = fit_to_nominal(ContourGeometry(contour), nominal, options);
        ASSERT_TRUE(found) << found.error().message;
        EXPECT_NEAR(found->motion.turn_rad, put.turn_rad, turn_limit_rad);
        EXPECT_LT((found->motion.apply(put.about_mm) - put.apply(put.about_mm)).norm(), place_limit_mm);
        EXPECT_LT(found->largest_mm, place_limit_mm);
    }
}

TEST(BestFit, IntoTheZonesWhenLeastSquaresStayOutside) {
    // A narrow zone at the edges and a wide one at the sides: an edge that is bent is brought in at the cost of the
    // sides.
    const auto section = blade(10);
    const auto nominal = curve_of(section);
    const auto put = motion_about_centre(section, {0.0, 0.0}, 0.0);
    const auto bent = [](double t) {
        return t < 1.0 ? 0.03 * std::sin(std::numbers::pi * (2.0 * t - 1.0) / 2.0) : 0.0;
    };
    const auto contour = contour_of(section, put, bent, 2400);
    BestFitOptions options;
    options.tolerance = {ToleranceZone{0.0, 0.02}, {0.0, 0.2}, {0.0, 0.2}, {0.0, 0.2}};
    const auto worst_share = [&](const BestFit& fit) {
        double worst = 0.0;
        for (const auto& point : contour) {
            const double d = nominal.closest(fit.motion.undo(point.position_mm)).distance_mm;
            worst = std::max(worst, std::abs(d) / options.tolerance[static_cast<std::size_t>(point.zone)].half_mm);
        }
        return worst;
    };
    const auto squares = fit_to_nominal(ContourGeometry(contour), nominal, options);
    options.objective = FitObjective::into_tolerance;
    const auto inside = fit_to_nominal(ContourGeometry(contour), nominal, options);
    ASSERT_TRUE(squares && inside);
    EXPECT_GT(worst_share(*squares), 1.2);
    EXPECT_LT(worst_share(*inside), 1.0);
}

TEST(BestFit, TheSlopesAreThoseOfDifferences) {
    const auto section = blade(12);
    const auto nominal = curve_of(section);
    const auto put = motion_about_centre(section, {0.03, 0.02}, 0.001);
    // Small ones: what a deviation times the edge's curvature adds is of second order.
    const auto bump = [](double t) { return 0.002 * std::sin(1.7 * t) + 0.0011 * std::cos(5.1 * t + 1.0); };
    const auto contour = contour_of(section, put, bump, 400);
    for (const auto objective : objectives) {
        BestFitOptions options;
        options.objective = objective;
        const auto found = fit_to_nominal(ContourGeometry(contour), nominal, options);
        ASSERT_TRUE(found);
        // A push of all points by a smooth wave.
        const auto push = [](std::size_t i) { return 1e-6 * std::cos(2.3 * 4.0 * static_cast<double>(i) / 400.0); };
        auto pushed = contour;
        for (std::size_t i = 0; i < pushed.size(); ++i)
            pushed[i].position_mm += push(i) * pushed[i].normal;
        const auto after = fit_to_nominal(ContourGeometry(pushed), nominal, options);
        ASSERT_TRUE(after);
        const auto foretold = [&](const Measure& measure) {
            double sum = 0.0;
            for (const auto& [point, weight] : measure.slopes.parts())
                sum += weight * push(point);
            return sum;
        };
        EXPECT_NEAR(after->dx.value - found->dx.value, foretold(found->dx), 5e-8) << to_string(objective);
        EXPECT_NEAR(after->dy.value - found->dy.value, foretold(found->dy), 5e-8) << to_string(objective);
        EXPECT_NEAR(after->twist.value - found->twist.value, foretold(found->twist), 5e-9) << to_string(objective);
        EXPECT_GT(std::abs(foretold(found->dx)) + std::abs(foretold(found->dy)), 2e-7);
    }
}

}  // namespace
}  // namespace cmm::fitting
