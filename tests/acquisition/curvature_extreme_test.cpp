// SPDX-License-Identifier: Apache-2.0
/// Curvatures over windows against those of blades that are formulas, and how often their intervals hold the truth.
#include "acquisition/curvature_extreme.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "acquisition/asked_characteristics.hpp"
#include "acquisition/evaluation.hpp"
#include "acquisition/part_file.hpp"
#include "core/text.hpp"
#include "fitting/best_fit.hpp"
#include "support/families.hpp"
#include "support/true_curvature.hpp"
#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {
namespace {

using fitting::TrueCurvature;
using fitting::Zone;
using fitting::families::Blade;
using fitting::families::Vec2;
using Kind = CharacteristicKind;

fitting::NominalSection nominal_of(const Blade& blade) {
    std::vector<Vec2> points;
    constexpr int nominal_points = 6000;
    for (int k = 0; k < nominal_points; ++k)
        points.push_back(blade.at(4.0 * k / nominal_points).position);
    fitting::NominalOptions hints;
    hints.le_hint = blade.le().nose;
    hints.te_hint = blade.te().nose;
    return fitting::analyse_nominal(points, hints).value();
}

CharacteristicSpec asked_for(Kind kind, Zone zone, double window_mm) {
    CharacteristicSpec spec;
    spec.kind = kind;
    spec.zone = zone;
    spec.window_mm = window_mm;
    spec.label = label_of(spec, "");
    return spec;
}

/// A blade that is a formula, with its curvature.
struct KnownBlade {
    explicit KnownBlade(Blade of) : blade(std::move(of)), curvature([&](double t) { return blade.at(t); }) {}
    double mean_near(const Vec2& p, double window_mm) const {
        return curvature.mean(curvature.arc_of(blade.closest(p).t), window_mm);
    }
    Blade blade;
    TrueCurvature curvature;
};

/// The extreme of the formula over the nominal's zone, the actual blade being laid on it by its best fit.
double truth_of(const CharacteristicSpec& spec, const fitting::NominalSection& nominal, const KnownBlade& drawn,
                const KnownBlade& made, const fitting::PlaneMotion& motion) {
    const auto span = nominal.span_of(*spec.zone);
    const double room = span.to_mm - span.from_mm - spec.window_mm;
    constexpr int steps = 400;
    double largest = -1e300;
    for (int k = 0; k <= steps; ++k) {
        const double s = span.from_mm + 0.5 * spec.window_mm + room * k / steps;
        const Vec2 p = nominal.curve().position(nominal.curve().wrap(s));
        const double there = made.mean_near(motion.apply(p), spec.window_mm);
        const double value = spec.kind == Kind::least_curvature ? -there
                             : spec.kind == Kind::greatest_curvature
                                 ? there
                                 : std::abs(there - drawn.mean_near(p, spec.window_mm));
        largest = std::max(largest, value);
    }
    return spec.kind == Kind::least_curvature ? -largest : largest;
}

/// What is asked of every blade: a tenth of a side's length as window, 0.6 of an edge's.
std::vector<CharacteristicSpec> all_specs(const fitting::NominalSection& nominal) {
    std::vector<CharacteristicSpec> out;
    for (const Zone zone : {Zone::le, Zone::suction, Zone::te, Zone::pressure}) {
        const auto span = nominal.span_of(zone);
        const bool edge = zone == Zone::le || zone == Zone::te;
        for (const Kind kind : {Kind::least_curvature, Kind::greatest_curvature, Kind::curvature_deviation})
            out.push_back(asked_for(kind, zone, (edge ? 0.6 : 0.1) * (span.to_mm - span.from_mm)));
    }
    return out;
}

SectionResult measured(
    const Blade& blade, const fitting::NominalSection& nominal, const std::vector<CharacteristicSpec>& specs,
    double sigma_mm, std::uint64_t seed, std::size_t points = 600,
    const std::function<double(double)>& dent = [](double) { return 0.0; }) {
    fitting::families::ScanOptions scanning;
    scanning.points = points;
    scanning.sigma_mm = sigma_mm;
    scanning.bad_share = 0.0;
    scanning.seed = seed;
    auto scan = fitting::families::scan(blade, scanning);
    for (std::size_t i = 0; i < scan.points.size(); ++i)
        scan.points[i] += dent(scan.t[i]) * blade.at(scan.t[i]).normal();
    fitting::SectionOptions options;
    options.ball_radius_mm = scanning.ball_mm;
    options.le_hint = blade.le().nose;
    options.te_hint = blade.te().nose;
    // A drawing says what its edges are.
    const auto model = [](const fitting::families::End& end) {
        return end.along == end.across ? fitting::EdgeModel::arc : fitting::EdgeModel::ellipse;
    };
    options.le_model = model(blade.le());
    options.te_model = model(blade.te());
    EvaluationOptions judging;
    judging.asked = specs;
    SectionResult section;
    section.points.resize(scan.points.size());
    NominalContour contour;
    for (const auto& p : section_of_nominal(nominal).contour)
        contour.points.push_back(p.position_mm);
    const ReferenceContour reference(contour, nominal.curve(), scanning.ball_mm);
    return evaluate_section(std::move(section), fitting::fit_section(scan.points, {}, options), &reference, judging,
                            &nominal);
}

/// Another blade than the one that was drawn: thicker, a little more cambered.
Blade made_from(const Blade& drawn) {
    auto shape = drawn.shape();
    shape.thickness *= 1.03;
    shape.camber *= 1.002;
    return {shape, drawn.name() + " as made"};
}

fitting::PlaneMotion exact_motion(const Blade& made, const fitting::NominalSection& drawn) {
    const auto exact = section_of_nominal(nominal_of(made));
    const fitting::ContourGeometry contour(exact.contour);
    return fitting::fit_to_nominal(contour, drawn.curve()).value().motion;
}

struct Count {
    int trials = 0, held = 0;
    double errors = 0.0, wide = 0.0;  // squares

    void add(const Characteristic& c, double truth) {
        const double error = c.value.value_or(1e300) - truth, u95 = c.u95.value_or(0.0);
        ++trials;
        held += std::abs(error) <= u95;
        errors += error * error;
        wide += u95 * u95;
    }
    double share() const { return static_cast<double>(held) / trials; }
    double width() const { return std::sqrt(wide / errors); }
};

/// Blades as drawn and blades that are not, of three families, with 1, 2 and 5 um of noise. The largest of many
/// numbers that are all the same but for noise is found too large by two of its standard deviations: the interval
/// has to reach back to the truth, and is wider than that of a number alone.
TEST(CurvatureExtreme, IntervalsHoldTheTruth) {
    constexpr std::uint64_t blades = 5;
    std::map<std::string, Count> counts;
    for (const auto family : fitting::families::all_families) {
        for (std::uint64_t seed = 1; seed <= blades; ++seed) {
            const KnownBlade drawn(fitting::families::make(family, seed));
            const auto nominal = nominal_of(drawn.blade);
            const auto specs = all_specs(nominal);
            for (const bool as_drawn : {true, false}) {
                const KnownBlade made(as_drawn ? drawn.blade : made_from(drawn.blade));
                const auto motion = as_drawn ? fitting::PlaneMotion{} : exact_motion(made.blade, nominal);
                std::map<std::string, double> truths;
                for (const auto& spec : specs)
                    truths[spec.label] = truth_of(spec, nominal, drawn, made, motion);
                for (const std::uint64_t um : {1, 2, 5}) {
                    const std::uint64_t trial = 1000 * seed + 10 * um + (as_drawn ? 0 : 1);
                    const auto section = measured(made.blade, nominal, specs, 1e-3 * static_cast<double>(um), trial);
                    for (const auto& spec : specs) {
                        const auto* c = section.find(spec.label);
                        ASSERT_TRUE(c != nullptr && c->value) << spec.label << section.why;
                        counts[std::string(to_string(spec.kind)) + " " + std::string(fitting::to_string(*spec.zone))]
                            .add(*c, truths[spec.label]);
                    }
                }
            }
        }
    }
    int held = 0, trials = 0;
    for (const auto& [name, count] : counts) {
        const double n = count.trials;
        EXPECT_EQ(count.trials, 90) << name;
        EXPECT_GT(count.share(), 0.95 - 3.0 * std::sqrt(0.95 * 0.05 / n)) << name;
        EXPECT_LT(count.width(), 6.0) << name << ": wide for safety";
        held += count.held;
        trials += count.trials;
    }
    EXPECT_GT(held, 0.95 * trials);
}

/// A dent of 60 um, a few millimetres wide, in a convex side: the curvature turns negative.
TEST(CurvatureExtreme, ADentIsASignChange) {
    const Blade drawn = fitting::families::make(fitting::families::Family::compressor, 3);
    const auto nominal = nominal_of(drawn);
    const auto spec = asked_for(Kind::least_curvature, Zone::suction, 4.0);
    auto limited = spec;
    limited.nominal = 0.0;
    limited.below = 0.0;
    for (const double depth_mm : {0.0, 0.06}) {
        const auto dent = [&](double t) { return -depth_mm * std::exp(-0.5 * std::pow((t - 3.5) / 0.03, 2)); };
        const auto section = measured(drawn, nominal, {limited}, 1e-3, 5, 900, dent);
        const auto* c = section.find(spec.label);
        ASSERT_TRUE(c && c->value && c->u95) << section.why;
        EXPECT_EQ(c->decision, depth_mm > 0.0 ? Decision::reject : Decision::accept) << *c->value << " " << *c->u95;
        if (depth_mm == 0.0) continue;
        double x = 0.0, y = 0.0;
        ASSERT_EQ(std::sscanf(c->note.c_str(), "at x %lf mm, y %lf mm", &x, &y), 2) << c->note;
        EXPECT_LT((Vec2(x, y) - drawn.at(3.5).position).norm(), 0.5) << "where the dent is";
    }
}

TEST(CurvatureExtreme, TheWindowIsPartOfTheMethod) {
    const KnownBlade drawn(fitting::families::make(fitting::families::Family::turbine, 2));
    const auto nominal = nominal_of(drawn.blade);
    const auto span = nominal.span_of(Zone::suction);
    const double length = span.to_mm - span.from_mm;
    std::vector<CharacteristicSpec> specs;
    for (const double share : {0.05, 0.3, 0.6, 1.1})
        specs.push_back(asked_for(Kind::greatest_curvature, Zone::suction, share * length));
    specs.push_back(asked_for(Kind::greatest_curvature, Zone::suction, 0.02));
    const auto section = measured(drawn.blade, nominal, specs, 1e-3, 4);
    double before = 1e9;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto* c = section.find(specs[k].label);
        ASSERT_TRUE(c && c->value && c->nominal) << specs[k].label;
        const double truth = truth_of(specs[k], nominal, drawn, drawn, {});
        EXPECT_NEAR(*c->nominal, truth, 1e-3 * truth) << "the nominal is looked at through the same window";
        EXPECT_LT(*c->value, before) << "a longer window evens out more";
        before = *c->value;
        EXPECT_NE(c->method.find(core::fixed(specs[k].window_mm, 3) + " mm"), std::string::npos) << c->method;
        EXPECT_EQ(c->unit, Unit::per_mm);
    }
    for (const std::size_t k : {3, 4}) {
        const auto* c = section.find(specs[k].label);
        EXPECT_EQ(c->decision, Decision::not_evaluable);
        EXPECT_NE(c->note.find(k == 3 ? "shorter than the window" : "fewer than"), std::string::npos) << c->note;
    }
}

TEST(CurvatureExtreme, WithoutANominalTheZonesAreThoseOfTheContour) {
    const Blade blade = fitting::families::make(fitting::families::Family::compressor, 4);
    const auto nominal = nominal_of(blade);
    const auto greatest = asked_for(Kind::greatest_curvature, Zone::suction, 3.0);
    const auto deviation = asked_for(Kind::curvature_deviation, Zone::suction, 3.0);
    const auto with = measured(blade, nominal, {greatest}, 1e-3, 4);
    EvaluationOptions judging;
    judging.asked = {greatest, deviation};
    const auto without = evaluate_section({}, *with.fit, nullptr, judging);
    const auto *a = with.find(greatest.label), *b = without.find(greatest.label);
    ASSERT_TRUE(a && b && a->value && b->value);
    EXPECT_NEAR(*a->value, *b->value, *a->u95);
    EXPECT_FALSE(b->nominal);
    EXPECT_EQ(without.find(deviation.label)->decision, Decision::not_evaluable);
    EXPECT_NE(without.find(deviation.label)->note.find("no nominal"), std::string::npos);
}

TEST(CurvatureExtreme, IsReadFromThePartFile) {
    const auto read = [](const std::string& keys) {
        return parse_part_file(session_part_text() + "[[characteristic]]\nname = \"curvature_deviation\"\n" + keys,
                               "p.toml");
    };
    const auto part = read("zone = \"le\"\nwindow_mm = 0.25\ntolerance_per_mm = 0.4\n");
    ASSERT_TRUE(part) << part.error().text();
    const auto& spec = part->gate.characteristics.at(0);
    EXPECT_EQ(spec.label, "curvature_deviation_le_0.25");
    EXPECT_EQ(spec.above, 0.4);
    EXPECT_FALSE(spec.below);
    EXPECT_EQ(spec.nominal, 0.0);
    const auto error_of = [&](const std::string& keys) {
        const auto wrong = read(keys);
        return wrong ? std::string() : wrong.error().text();
    };
    EXPECT_NE(error_of("zone = \"le\"\n").find("window_mm"), std::string::npos);
    EXPECT_NE(error_of("window_mm = 1\n").find("zone"), std::string::npos);
    EXPECT_NE(error_of("zone = \"all\"\nwindow_mm = 1\n").find("zone"), std::string::npos);
    EXPECT_NE(error_of("zone = \"le\"\nwindow_mm = 1\nupper_per_mm = 1\n").find("tolerance_per_mm"), std::string::npos);
    EXPECT_NE(error_of("zone = \"le\"\nwindow_mm = 1\nupper_mm = 1\n").find("upper_mm"), std::string::npos);
}

}  // namespace
}  // namespace cmm::acquisition
