// SPDX-License-Identifier: Apache-2.0
/// What machine, probe and temperature do to a section, against brute force: points displaced by formulas of their own,
/// fitted again.
#include "fitting/error_fields.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "fitting/area_measures.hpp"
#include "fitting/best_fit.hpp"
#include "fitting/chord.hpp"
#include "fitting/datum.hpp"
#include "fitting/thickness_measures.hpp"
#include "fitting/throat.hpp"
#include "support/drawn_errors.hpp"
#include "support/formed_nominal.hpp"

namespace cmm::fitting {
namespace {

using drawn_errors::Machine;
using Eigen::Vector3d;

constexpr double um = 1e-3;
constexpr double usual_sigma_mm = 0.5 * um;

struct Subject {
    explicit Subject(families::Family family, std::uint64_t seed)
        : blade(families::make(family, seed)), nominal(formed::itself(blade)) {}

    static EdgeModel form_of(const families::End& end) {
        return end.along == end.across ? EdgeModel::arc : EdgeModel::ellipse;
    }

    SectionFit fit(const Machine& machine, double sigma_mm = usual_sigma_mm) const {
        families::ScanOptions scanning;
        // What an error turns by itself, such as whether an edge is a conic up to its joints, is worth least among
        // many.
        scanning.points = 2000;
        scanning.sigma_mm = sigma_mm;
        scanning.bad_share = 0.0;
        auto scan = families::scan(blade, scanning);
        drawn_errors::displace(blade, machine, scan);
        SectionOptions options;
        options.ball_radius_mm = scanning.ball_mm;
        options.le_hint = blade.le().nose;
        options.te_hint = blade.te().nose;
        options.le_model = form_of(blade.le());
        options.te_model = form_of(blade.te());
        return fit_section(scan.points, {}, options).value();
    }

    families::Blade blade;
    ClosedCurve nominal;
};

using Measures = std::map<std::string, Measure>;

Measures measures_of(const SectionFit& fit, const Subject& subject) {
    MeasuredSection section(fit);
    Measures out;
    const auto add = [&](const std::string& name, const core::Result<Measure>& measure) {
        ASSERT_TRUE(measure) << name << ": " << measure.error().message;
        out.emplace(name, *measure);
    };
    add("chord NOSETAIL", measure_chord(section, ChordMethod::nose_tail));
    add("chord BELAC", measure_chord(section, ChordMethod::belac, 0.4));
    add("chord XAXIS", measure_chord(section, ChordMethod::x_axis));
    add("chord MAXDIST", measure_chord(section, ChordMethod::largest));
    add("chord MINCIRCLE", measure_chord(section, ChordMethod::min_circle));
    add("stagger", measure_stagger(section, StaggerMethod::nose_tail));
    add("max_thickness", measure_max_thickness(section));
    add("LE thickness", measure_edge_thickness(section, EdgeName::le, 3.0));
    add("TE thickness", measure_edge_thickness(section, EdgeName::te, 3.0));
    add("throat", measure_throat(section, {0.0, 0.9 * subject.blade.shape().chord}));
    const AreaMeasures area = measure_area(section);
    add("area", area.area);
    add("centroid x", area.centroid_x);
    const auto moved = fit_to_nominal(section.contour(), subject.nominal);
    add("displacement x", moved->dx);
    add("displacement y", moved->dy);
    add("twist", moved->twist);
    const auto radius = [&](const std::string& name, const EdgeFit& edge, EdgeModel model) {
        // Only of the same form: another one has another radius.
        if (edge.valid && edge.model == model) out.emplace(name, Measure{"", edge.radius_mm, edge.slopes[2], {}});
    };
    radius("LE radius", fit.le, Subject::form_of(subject.blade.le()));
    radius("TE radius", fit.te, Subject::form_of(subject.blade.te()));
    return out;
}

/// By a displacement of the contour that a formula says.
double predicted(const SectionFit& fit, const Sensitivity& number, const Machine& machine) {
    double sum = 0.0;
    for (const auto& [i, weight] : number.parts()) {
        const ContourPoint& p = fit.contour[i];
        const Vector3d normal(p.normal.x(), p.normal.y(), 0.0);
        sum += weight * machine.of({p.position_mm.x(), p.position_mm.y(), 0.0}, normal, 0.0).dot(normal);
    }
    return sum;
}

/// The farthest that any weight could make of it.
double largest_of(const SectionFit& fit, const Sensitivity& number, const Machine& machine) {
    double sum = 0.0;
    for (const auto& [i, weight] : number.parts()) {
        Sensitivity one;
        one.add(i, weight);
        sum += std::abs(predicted(fit, one, machine));
    }
    return sum;
}

std::map<std::string, Machine> single_errors() {
    constexpr double lobes = 0.5 * um;  // more, and the edges have no longer the form that they had
    std::map<std::string, Machine> all;
    all["ball"].ball_mm = 3 * um;
    for (std::size_t m = 1; m <= 4; ++m) {
        all["lobes, cosine " + std::to_string(m)].lobes[m].mm = Vec2(lobes, 0.0);
        all["lobes, sine " + std::to_string(m)].lobes[m].mm = Vec2(0.0, lobes);
    }
    all["scale x"].strain(0, 0) = 1e-4;
    all["scale y"].strain(1, 1) = 1e-4;
    all["square"].strain(0, 1) = all["square"].strain(1, 0) = 1e-4;
    all["growth"].growth = 1e-4;
    return all;
}

/// Between nose and tail the slopes are 1.12 times as steep on purpose (camber_line.cpp).
double slack_of(const std::string& name) {
    return name == "chord NOSETAIL" || name == "stagger" ? 0.14 : 0.0;
}

/// How far a fit follows its points is told by them, so by a part of their noise a number answers otherwise.
void expect_to_move_as_slopes_say(const Subject& subject, double sigma_mm, double floor_mm) {
    const SectionFit before = subject.fit({}, sigma_mm);
    const Measures exact = measures_of(before, subject);
    std::size_t compared = 0;
    for (const auto& [error, machine] : single_errors()) {
        const Measures moved = measures_of(subject.fit(machine, sigma_mm), subject);
        for (const auto& [name, measure] : exact) {
            if (!moved.contains(name)) continue;
            // Lobes of an edge change how much of it is taken for an arc: see CharacteristicCoverage.
            if (name.ends_with("radius") && error.starts_with("lobes") && !error.ends_with("1")) continue;
            const double slope = predicted(before, measure.slopes, machine);
            const double most = largest_of(before, measure.slopes, machine);
            EXPECT_NEAR(moved.at(name).value - measure.value, slope,
                        slack_of(name) * std::abs(slope) + 0.05 * most + floor_mm)
                << subject.blade.name() << ", " << error << ": " << name;
            ++compared;
        }
    }
    EXPECT_GT(compared, 200U);
}

TEST(ErrorFields, EveryNumberMovesAsItsSlopesSay) {
    for (const auto& [family, seed] : {std::pair{families::Family::compressor, 12U},
                                       {families::Family::turbine, 5U},
                                       {families::Family::fan, 12U}}) {
        const Subject subject(family, seed);
        expect_to_move_as_slopes_say(subject, 0.2 * um, 0.05 * um);
        expect_to_move_as_slopes_say(subject, usual_sigma_mm, 0.1 * um);
    }
}

SystematicErrors some_errors() {
    SystematicErrors errors;
    errors.ball_mm = 0.4 * um;
    errors.form_mm = 0.7 * um;
    errors.constant_mm = 1.5 * um;
    errors.per_mm = 8e-6;
    errors.expansion = 6e-6;
    return errors;
}

/// Standard deviation over draws of the machine, without what differs from place to place.
TEST(ErrorFields, TheVarianceOfANumberIsThatOfManyMachines) {
    const Subject subject(families::Family::turbine, 5);
    SectionFit fit = subject.fit({});
    const auto errors = some_errors();
    fit.contour_noise.set_fields(ErrorFields(errors, 0.0));
    core::Rng rng(17);
    std::vector<Machine> machines;
    for (int k = 0; k < 3000; ++k) {
        machines.push_back(drawn_errors::draw(errors, rng));
        machines.back().waves = {};
    }
    for (const auto& [name, measure] : measures_of(fit, subject)) {
        double squares = 0.0;
        Sensitivity few;  // a best fit answers to all points: every seventh is enough to compare
        for (std::size_t i = 0; i < measure.slopes.parts().size(); i += 1 + measure.slopes.parts().size() / 400)
            few.add(measure.slopes.parts()[i].first, measure.slopes.parts()[i].second);
        for (const Machine& machine : machines)
            squares += std::pow(predicted(fit, few, machine), 2);
        const double drawn = std::sqrt(squares / static_cast<double>(machines.size()));
        const double stated = std::sqrt(variance_of(fit.contour_noise.loads(fit.contour, few)));
        EXPECT_NEAR(drawn / stated, 1.0, 0.05) << name;
    }
}

TEST(ErrorFields, ALengthHasTheUncertaintyOfTheDataSheetInEveryDirection) {
    SystematicErrors errors;
    errors.constant_mm = 1.0 * um;
    errors.per_mm = 5e-6;
    for (const double along_rad : {0.0, 0.5, 1.2, 2.7}) {
        for (const double rise : {0.0, 0.3, -1.5}) {
            // Between two faces across the direction: their normals look away from each other.
            const double cosine = 1.0 / std::hypot(1.0, rise), half = 40.0;
            const Vec2 level = cosine * Vec2(std::cos(along_rad), std::sin(along_rad));
            const Vec2 heading = level / cosine;
            const ErrorFields above(errors, 7.0 + half * cosine * rise), below(errors, 7.0 - half * cosine * rise);
            const FieldLoads far = above.at(Vec2(3.0, -2.0) + half * level, heading, rise) * cosine;
            const FieldLoads near = below.at(Vec2(3.0, -2.0) - half * level, -heading, -rise) * cosine;
            // `at` is a displacement in the plane; times the cosine of the lean it is that along the normal.
            const double places = 2.0 * std::pow(above.place_mm(rise) * cosine, 2);
            EXPECT_NEAR(std::sqrt(variance_of(far + near, ErrorSource::length) + places),
                        std::hypot(errors.constant_mm, 2.0 * half * errors.per_mm), 1e-9)
                << along_rad << " " << rise;
        }
    }
}

TEST(ErrorFields, EachSourceHasItsOwnPartOfTheBudget) {
    const Subject subject(families::Family::compressor, 12);
    SectionFit fit = subject.fit({});
    fit.contour_noise.set_fields(ErrorFields(some_errors(), 0.0));
    MeasuredSection section(fit);
    const auto thickness = measure_max_thickness(section).value();
    const auto u = section.uncertainty(thickness);
    EXPECT_NEAR(u.budget.of(ErrorSource::ball), 2.0 * 0.4 * um, 1e-5) << "both walls are too thick by it";
    EXPECT_NEAR(u.budget.of(ErrorSource::temperature), 6e-6 * thickness.value, 1e-7);
    EXPECT_NEAR(u.budget.of(ErrorSource::length), 1.5 * um, 0.1 * um);
    const double noise = u.budget.noise, shared = u.budget.shared();
    EXPECT_NEAR(u.u95, fit.contour_noise.coverage() * std::hypot(noise, shared) + u.budget.bound, 1e-12);
    EXPECT_NEAR(variance_of(u.loads) + std::pow(u.place, 2), std::pow(shared, 2), 1e-15);

    SystematicErrors known;
    known.known_expansion = 20e-6;
    fit.contour_noise.set_fields(ErrorFields(known, 0.0));
    const auto too_long = section.uncertainty(thickness);
    EXPECT_NEAR(too_long.budget.bound, 20e-6 * thickness.value, 1e-7) << "what is known is added as it is";
    EXPECT_EQ(too_long.budget.shared(), 0.0);
}

TEST(ErrorFields, WithoutThemNothingChanges) {
    const Subject subject(families::Family::fan, 12);
    SectionFit fit = subject.fit({});
    const auto all = measures_of(fit, subject);
    SectionFit told = fit;
    told.contour_noise.set_fields(ErrorFields(SystematicErrors{}, 30.0));
    for (const auto& [name, measure] : all) {
        const auto before = fit.contour_noise.of(fit.contour, measure.slopes);
        const auto after = told.contour_noise.of(told.contour, measure.slopes);
        EXPECT_EQ(before.u95, after.u95) << name;
        EXPECT_EQ(before.standard, after.standard) << name;
        EXPECT_EQ(before.scatter, after.standard) << name;
        EXPECT_EQ(after.budget.shared(), 0.0) << name;
    }
}

/// An alignment takes a shift of the whole machine away, whatever made it, and the ball's radius not.
TEST(ErrorFields, WhatAnAlignmentTakesAwayDoesNotCount) {
    const Subject subject(families::Family::turbine, 5);
    SectionFit fit = subject.fit({});
    MeasuredSection section(fit);
    const MeasuredSection* const only = &section;
    const auto found = fit_to_nominal(section.contour(), subject.nominal).value();
    const auto largest = [&](const SystematicErrors& errors, ErrorSource source) {
        fit.contour_noise.set_fields(ErrorFields(errors, 0.0));
        const Datum datum = datums_of(found, {&only, 1}).front();
        auto contour = fit.contour;
        set_place_errors(contour, fit.contour_noise, &datum);
        double most = 0.0;
        for (const auto& point : contour)
            most = std::max(most, point.machine.standard_mm[static_cast<std::size_t>(source)]);
        return most;
    };
    SystematicErrors ball, length, growth;
    ball.ball_mm = 1.0 * um;
    length.per_mm = 5e-6;
    growth.expansion = 10e-6;
    length.fixed_at_mm = growth.fixed_at_mm = {300.0, -400.0, 0.0};
    EXPECT_GT(largest(ball, ErrorSource::ball), 0.6 * um) << "a ball too large is no motion";
    // Far from where lengths count from nearly all of it is a shift or a turn; of what is left the part's size counts.
    const double size_mm = subject.blade.shape().chord;
    EXPECT_LT(largest(length, ErrorSource::length), 5e-6 * size_mm);
    EXPECT_LT(largest(growth, ErrorSource::temperature), 10e-6 * size_mm);
    auto contour = fit.contour;
    set_place_errors(contour, fit.contour_noise, nullptr);
    double most = 0.0;
    for (const auto& point : contour)
        most = std::max(most, point.machine.shared_mm());
    EXPECT_GT(most, 10e-6 * 400.0) << "as measured it counts in full";
}

DatumPoint datum(const Vector3d& at, const Vector3d& normal) {
    return {at, normal.normalized()};
}

SixPoints single_touches() {
    return {datum({30.0, 4.0, 10.0}, {0.1, 1.0, 0.2}),    datum({-25.0, 3.0, 15.0}, {-0.2, 1.0, 0.1}),
            datum({0.0, 5.0, 85.0}, {0.0, 1.0, -0.1}),    datum({-35.0, -2.0, 20.0}, {-1.0, -0.1, 0.0}),
            datum({-36.0, -1.0, 80.0}, {-1.0, 0.2, 0.1}), datum({5.0, 0.0, 100.0}, {0.0, 0.0, 1.0})};
}

/// The first three are middles between the sides.
SixPoints middles() {
    SixPoints points = single_touches();
    for (const std::size_t i : {0U, 1U, 2U}) {
        const Vector3d across(0.0, -2.0 * points[i].place_mm.y(), 0.0);
        points[i].opposite = DatumTouch{points[i].place_mm + across, Vector3d(0.1, -1.0, 0.05).normalized()};
    }
    return points;
}

/// Against frames found from touches displaced by formulas of the test.
void expect_loads_of_frame(const SixPoints& points) {
    const auto errors = some_errors();
    const double ball_mm = 1.5, rise = 0.2, z_mm = 60.0;
    ErrorFields fields(errors, z_mm);
    const Vec2 at(20.0, -3.0), heading(std::cos(-1.0), std::sin(-1.0));
    const double as_measured = variance_of(fields.at(at, heading, rise));
    fields.lie_in_frame_of(points);
    const FieldLoads net = fields.at(at, heading, rise);
    core::Rng rng(5);
    double squares = 0.0;
    constexpr int draws = 4000;
    for (int k = 0; k < draws; ++k) {
        auto machine = drawn_errors::draw(errors, rng);
        machine.waves = {};
        TouchCentres centres;
        for (const auto& [place, normal] : touches_of(points)) {
            // A touch from above has no direction of its own in the formulas of the test: it errs by nothing there.
            auto felt = machine;
            if (normal.head<2>().norm() < 0.5) felt.lobes = {};
            centres.emplace_back(place + ball_mm * normal + felt.of(place, normal, 0.0));
        }
        const auto frame = solve_six_points(points, centres, ball_mm, Eigen::Isometry3d::Identity()).value();
        const Vector3d wall(at.x(), at.y(), z_mm), facing(heading.x(), heading.y(), rise);
        const Vector3d measured = wall + machine.of(wall, facing.normalized(), 0.0);
        squares += std::pow((frame.inverse() * measured - wall).dot(facing), 2);
    }
    EXPECT_NEAR(std::sqrt(squares / draws / variance_of(net)), 1.0, 0.05);
    EXPECT_GT(std::abs(variance_of(net) / as_measured - 1.0), 0.2) << "the frame matters";
}

/// The touches of a frame err by the same machine.
TEST(ErrorFields, AFrameOfSixPointsErrsWithItsMachine) {
    expect_loads_of_frame(single_touches());
    const Matrix6 own = ErrorFields::covariance_of_touches(some_errors(), single_touches());
    for (Eigen::Index i = 0; i < 6; ++i)
        EXPECT_GT(own(i, i), 0.0) << "what differs from place to place moves the frame by itself";
}

TEST(ErrorFields, AMiddleOfTwoTouchesErrsByHalfTheirDifference) {
    expect_loads_of_frame(middles());
    // A ball that is too large moves both touches outwards, and their middle hardly.
    SystematicErrors ball;
    ball.ball_mm = 1e-3;
    const auto moved_mm = [&](const SixPoints& points) {
        ErrorFields fields(ball, 60.0);
        fields.lie_in_frame_of(points);
        return std::sqrt(fields.covariance_of_frame()(1, 1));
    };
    EXPECT_GT(moved_mm(single_touches()), 0.5e-3);
    EXPECT_LT(moved_mm(middles()), 0.2e-3);
    EXPECT_LT(ErrorFields::covariance_of_touches(some_errors(), middles())(1, 1),
              0.8 * ErrorFields::covariance_of_touches(some_errors(), single_touches())(1, 1));
}

}  // namespace
}  // namespace cmm::fitting
