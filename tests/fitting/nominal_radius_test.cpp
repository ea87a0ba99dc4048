// SPDX-License-Identifier: Apache-2.0
#include "fitting/nominal_radius.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "fitting/chord.hpp"
#include "support/natural_blade.hpp"
#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

constexpr double ball_mm = 1.0;

/// Both edges.
SectionFit measured_as(EdgeModel model, double arc_rad) {
    SectionFit fit;
    for (EdgeFit* const edge : {&fit.le, &fit.te}) {
        edge->valid = true;
        edge->model = model;
        edge->arc_angle_rad = arc_rad;
    }
    return fit;
}

TEST(NominalRadius, IsThatOfTheDrawingWhereTheEdgeHasTheForm) {
    const auto outline = truth::envelope_blade({});
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < outline.points.size(); i += 20)
        points.push_back(outline.points[i]);
    const auto arcs = analyse_nominal(points);
    ASSERT_TRUE(arcs);
    for (const double arc_rad : {1.2, 2.0, 2.6})
        for (const EdgeModel model : {EdgeModel::arc, EdgeModel::ellipse}) {
            const auto le = nominal_radius(*arcs, EdgeName::le, measured_as(model, arc_rad));
            const auto te = nominal_radius(*arcs, EdgeName::te, measured_as(model, arc_rad));
            ASSERT_TRUE(le && te);
            EXPECT_NEAR(*le, 0.6, 2e-4) << arc_rad;
            EXPECT_NEAR(*te, 0.3, 2e-4) << arc_rad;
            const auto chord = nominal_rad_center(*arcs, measured_as(model, arc_rad));
            ASSERT_TRUE(chord);
            EXPECT_NEAR(*chord, 40.0, 2e-4) << arc_rad;
        }

    points.clear();
    for (int i = 0; i < 4000; ++i) {
        const double a = 2.0 * std::numbers::pi * i / 4000.0;
        points.emplace_back(30.0 * std::cos(a), 3.0 * std::sin(a));
    }
    const auto ellipse = analyse_nominal(points, {Vec2(30.0, 0.0), Vec2(-30.0, 0.0)});
    ASSERT_TRUE(ellipse);
    for (const double arc_rad : {1.2, 2.0, 2.6}) {
        const auto nose = nominal_radius(*ellipse, EdgeName::le, measured_as(EdgeModel::ellipse, arc_rad));
        ASSERT_TRUE(nose);
        EXPECT_NEAR(*nose, 0.3, 1e-5) << arc_rad;
        const auto chord = nominal_rad_center(*ellipse, measured_as(EdgeModel::ellipse, arc_rad));
        ASSERT_TRUE(chord);
        EXPECT_NEAR(*chord, 60.0, 1e-5) << arc_rad;
    }
    const auto circle = nominal_radius(*ellipse, EdgeName::le, measured_as(EdgeModel::free, 2.0));
    ASSERT_TRUE(circle) << circle.error().message;
    EXPECT_GT(*circle, 0.31) << "a circle is wider than the nose";
}

/// The noses of a thickness law have no form: circle, ellipse and parabola give radii that are far from each other, and
/// noise decides which of them the points support. The nominal is one with each of them.
TEST(NominalRadius, OfNosesWithoutAFormIsThatOfTheSameForm) {
    std::set<EdgeModel> seen;
    double same = 0.0, scale = 0.0;
    int count = 0, chords = 0;
    for (const bool slender : {false, true})
        for (std::uint64_t seed = 1; seed <= 12; ++seed) {
            const natural::Blade blade(seed, slender);
            std::vector<Vec2> outline;
            for (int i = 0; i < 4000; ++i)
                outline.push_back(blade.at((i + 0.5) / 4000.0).position);
            const auto nominal = analyse_nominal(outline, {blade.le(), blade.te()});
            ASSERT_TRUE(nominal);
            const auto scan = blade.scan(seed, ball_mm, 8.0);
            SectionOptions options;
            options.ball_radius_mm = ball_mm;
            options.le_hint = blade.le();
            options.te_hint = blade.te();
            const auto fit = fit_section(scan.centres, {}, options);
            ASSERT_TRUE(fit);
            if (!fit->le.valid) continue;
            const auto of_nominal = nominal_radius(*nominal, EdgeName::le, *fit);
            ASSERT_TRUE(of_nominal) << of_nominal.error().message;
            const double off = *of_nominal / fit->le.radius_mm - 1.0;
            const double off_scale = nominal->le_radius_mm() / fit->le.radius_mm - 1.0;
            same += off * off;
            scale += off_scale * off_scale;
            seen.insert(fit->le.model);
            ++count;
            MeasuredSection section(*fit);
            const auto chord = measure_chord(section, ChordMethod::rad_center);
            if (!chord) continue;
            const auto nominal_chord = nominal_rad_center(*nominal, *fit);
            ASSERT_TRUE(nominal_chord) << nominal_chord.error().message;
            EXPECT_NEAR(*nominal_chord, chord->value, 0.01);
            ++chords;
        }
    EXPECT_GE(count, 18);
    EXPECT_GE(chords, 12);
    EXPECT_GE(seen.size(), 2U);
    EXPECT_LE(std::sqrt(same / count), 0.04) << "where the points lie on a mean circle is not known exactly";
    EXPECT_GE(std::sqrt(scale / count), 0.5) << "the mean radius of the sharpest 120 degrees is another";
}

}  // namespace
}  // namespace cmm::fitting
