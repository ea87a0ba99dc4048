// SPDX-License-Identifier: Apache-2.0
/// Characteristics of sections whose truth is a formula, without noise, through the whole fit.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <tuple>

#include "fitting/area_measures.hpp"
#include "fitting/best_fit.hpp"
#include "fitting/chord.hpp"
#include "fitting/thickness.hpp"
#include "fitting/thickness_measures.hpp"
#include "fitting/throat.hpp"
#include "support/exact_scan.hpp"
#include "support/section_truth.hpp"
#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

using section_truth::ExactSection;
using section_truth::SectionTruth;

constexpr double degree = std::numbers::pi / 180.0;
constexpr double tenth_um = 1e-4;

SectionFit fit_of(const ExactSection& section, double ball_mm = 1.0,
                  const std::array<std::size_t, 4>& counts = {400, 800, 400, 800}) {
    SectionOptions options;
    options.ball_radius_mm = ball_mm;
    options.le_hint = section.at(section.le_nose).position;
    options.te_hint = section.at(section.te_nose).position;
    auto fit = fit_section(section_truth::exact_scan(section, ball_mm, counts), {}, options);
    EXPECT_TRUE(fit) << section.name << ": " << (fit ? "" : fit.error().message);
    return fit ? std::move(*fit) : SectionFit{};
}

double value_of(const core::Result<Measure>& measure) {
    EXPECT_TRUE(measure) << (measure ? "" : measure.error().message);
    return measure ? measure->value : std::nan("");
}

/// Vane of the von Karman Institute's LS-89 by its main sizes (Arts, Lambert de Rouvroit, Rutherford 1990: chord 67.647
/// mm, LE radius 4.126 mm, TE radius 0.71 mm, stagger 55 degrees); not its coordinates.
ExactSection like_ls89() {
    families::Shape s;
    s.chord = 66.0;
    s.camber = std::tan(47.0 * degree) / 4;
    s.skew = -0.15;
    s.thickness = 11.0;
    s.forward = 0.6;
    s.le_along = s.le_across = 4.126;
    s.te_along = s.te_across = 0.71;
    s.le_wedge = std::atan(2.0 * 0.5 * s.thickness / s.chord);
    s.te_wedge = std::atan(0.9 * 0.5 * s.thickness / s.chord);
    s.stagger = -55.0 * degree;
    return section_truth::of_family(families::Blade(s, "like LS-89"));
}

/// What a line of inscribed circles is off the mean line of a section whose thickness is laid off across that
/// (docs/theory.md, section 13): the definition's, not the fit's.
TEST(Characteristics, TheCamberLineOfANacaSectionIsThatOfItsCircles) {
    const ExactSection naca = section_truth::naca_4_digit(60.0, 0.12, 0.04, 0.4, 0.25);
    const SectionTruth truth(naca);
    const SectionFit fit = fit_of(naca);
    MeasuredSection section(fit);
    ASSERT_TRUE(section.camber());
    EXPECT_LT((section.camber()->le().point() - truth.nose()).norm(), 2 * tenth_um);
    const Vec2 off = truth.nose() - naca.camber(0.0), chord = (naca.camber(1.0) - naca.camber(0.0)).normalized();
    EXPECT_NEAR(-off.dot(chord), 0.48e-3, 0.05e-3);
    EXPECT_NEAR(off.dot(section_truth::left(chord)), 2.5e-3, 0.2e-3);
}

TEST(Characteristics, OfASymmetricNacaSection) {
    // Half thickness 5 t (0.2969 v - 0.1260 x - ...): its maximum by the derivative, its chord by the rounded end.
    const double chord = 60.0, share = 0.12;
    const ExactSection naca = section_truth::naca_4_digit(chord, share, 0.0, 0.4, 0.25);
    const auto half = [&](double x) {
        return 5 * share *
               (0.2969 * std::sqrt(x) - 0.1260 * x - 0.3516 * x * x + 0.2843 * x * x * x - 0.1036 * x * x * x * x);
    };
    double low = 0.2, high = 0.4;
    while (high - low > 1e-13) {
        const double x = 0.5 * (low + high);
        const double slope = 0.14845 / std::sqrt(x) - 0.1260 - 0.7032 * x + 0.8529 * x * x - 0.4144 * x * x * x;
        (slope > 0.0 ? low : high) = x;
    }
    const double length = naca.at(2.5).position.x();
    const SectionFit fit = fit_of(naca);
    MeasuredSection section(fit);
    EXPECT_NEAR(value_of(measure_chord(section, ChordMethod::x_axis)), length, tenth_um);
    EXPECT_NEAR(value_of(measure_chord(section, ChordMethod::nose_tail)), length, tenth_um);
    EXPECT_NEAR(value_of(measure_chord(section, ChordMethod::largest)), length, tenth_um);
    EXPECT_NEAR(value_of(measure_chord(section, ChordMethod::min_circle)), length, tenth_um);
    EXPECT_NEAR(value_of(measure_max_thickness(section)), 2.0 * chord * half(low), tenth_um);
    EXPECT_NEAR(value_of(measure_max_thickness_position(section, PositionMethod::on_chord)), low * chord / length,
                1e-3);
    EXPECT_NEAR(value_of(measure_stagger(section, StaggerMethod::nose_tail)), 0.0, 2e-6);
    EXPECT_FALSE(measure_chord(section, ChordMethod::caliper)) << "no concave side";
}

TEST(Characteristics, OfCamberedNacaSections) {
    for (const auto& [thickness, camber] : {std::pair{0.10, 0.04}, std::pair{0.15, 0.06}}) {
        const auto naca =
            section_truth::placed(section_truth::naca_4_digit(50.0, thickness, camber, 0.4, 0.2), 0.6, {12.0, -7.0});
        const SectionTruth truth(naca);
        const SectionFit fit = fit_of(naca);
        MeasuredSection section(fit);
        EXPECT_NEAR(value_of(measure_chord(section, ChordMethod::x_axis)), truth.extent({1, 0}), tenth_um);
        EXPECT_NEAR(value_of(measure_chord(section, ChordMethod::nose_tail)), (truth.tail() - truth.nose()).norm(),
                    tenth_um);
        const auto thickest = truth.thickest();
        EXPECT_NEAR(value_of(measure_max_thickness(section)), thickest.diameter, tenth_um);
        EXPECT_NEAR(value_of(measure_max_thickness_position(section, PositionMethod::on_chord)), thickest.on_chord,
                    1e-3);
        const AreaMeasures area = measure_area(section);
        EXPECT_NEAR(area.area.value, truth.area(), 5e-3) << "0.05 um all round";
        EXPECT_NEAR(area.centroid_x.value, truth.centroid().x(), tenth_um);
        EXPECT_NEAR(area.centroid_y.value, truth.centroid().y(), tenth_um);
    }
}

TEST(Characteristics, CamberLineOfAnEnvelopeIsItsCircles) {
    for (const double camber : {0.0, 20.0, 55.0, 110.0}) {
        const double chord = 50.0, le = 0.6, te = 0.35, thickness = 4.5;
        const auto blade = section_truth::envelope(chord, thickness, camber * degree, le, te);
        const SectionFit fit = fit_of(blade);
        MeasuredSection section(fit);
        ASSERT_TRUE(section.camber()) << section.camber().error().message;
        const CamberLine& line = *section.camber();
        const double k = chord - le - te, th = camber * degree, big = th > 0 ? k / (2 * std::sin(th / 2)) : 0.0;
        double farthest = 0.0;
        for (const Vec2& p : line.points()) {
            if (std::abs(p.x()) > 0.5 * k)
                continue;  // beyond the end circles' centres there is no line to compare with
            const double off = th > 0 ? (p - Vec2(0, -big * std::cos(th / 2))).norm() - big : p.y();
            farthest = std::max(farthest, std::abs(off));
        }
        EXPECT_LT(farthest, 1e-3) << camber;
        // Nose and tail lie on the arc, one radius from the centres of the end circles.
        const auto end_of = [&](double radius) {
            const double a = th > 0 ? th / 2 + 2 * std::asin(radius / (2 * big)) : 0.0;
            return th > 0 ? Vec2(big * std::sin(a), big * (std::cos(a) - std::cos(th / 2))) : Vec2(k / 2 + radius, 0.0);
        };
        const Vec2 nose = end_of(le).cwiseProduct(Vec2(-1, 1)), tail = end_of(te);
        EXPECT_NEAR(value_of(measure_chord(section, ChordMethod::nose_tail)), (tail - nose).norm(), tenth_um) << camber;
        EXPECT_LT((line.le().point() - nose).norm(), 2 * tenth_um) << camber;
        EXPECT_LT((line.te().point() - tail).norm(), 2 * tenth_um) << camber;
        double largest = 0.0, at = 0.0;
        for (int i = 0; i <= 200000; ++i) {
            const double t = i / 200000.0, h = 0.5 * thickness - 0.5 * (le + te);
            const double rho = le * (1 - t) + te * t + h * 0.5 * (4 * t * (1 - t) + 6.75 * t * (1 - t) * (1 - t));
            if (rho > largest) {
                largest = rho;
                at = t;
            }
        }
        EXPECT_NEAR(value_of(measure_max_thickness(section)), 2.0 * largest, tenth_um) << camber;
        const double length = th > 0 ? big * th : k;
        EXPECT_NEAR(value_of(measure_max_thickness_position(section, PositionMethod::on_camber)),
                    (le + at * length) / (le + length + te), 1e-3)
            << camber;
        ASSERT_TRUE(fit.le.valid && fit.te.valid) << fit.le.why << fit.te.why;
        EXPECT_GT(fit.le.arc_angle_rad, 120 * degree);
        EXPECT_NEAR(fit.le.radius_mm, le, 5e-4);
        EXPECT_NEAR(fit.te.radius_mm, te, 5e-4);
    }
}

TEST(Characteristics, EachChordMethodHasItsOwnValue) {
    const ExactSection blade = like_ls89();
    const SectionTruth truth(blade);
    const SectionFit fit = fit_of(blade, 1.0, {500, 900, 300, 900});
    MeasuredSection section(fit);
    const auto chord = [&](ChordMethod method) { return value_of(measure_chord(section, method, -40.0 * degree)); };
    const double nose_tail = (truth.tail() - truth.nose()).norm();
    EXPECT_NEAR(chord(ChordMethod::nose_tail), nose_tail, 1e-3)
        << "continuation of the camber line at 94 degrees of turning";
    EXPECT_NEAR(chord(ChordMethod::caliper), truth.caliper().length, 2 * tenth_um);
    EXPECT_NEAR(chord(ChordMethod::belac), truth.extent({std::cos(-40 * degree), std::sin(-40 * degree)}), tenth_um);
    EXPECT_NEAR(chord(ChordMethod::x_axis), truth.extent({1, 0}), tenth_um);
    EXPECT_NEAR(chord(ChordMethod::largest), truth.largest_distance(), tenth_um);
    EXPECT_NEAR(chord(ChordMethod::min_circle), truth.min_circle(), tenth_um);
    // By the formula of the ends: circles whose centres are 4.126 and 0.71 mm from the camber's ends.
    const Vec2 le_nose = blade.at(0.5).position, te_nose = blade.at(2.5).position;
    const Vec2 le_centre = le_nose - 4.126 * blade.at(0.5).normal(),
               te_centre = te_nose - 0.71 * blade.at(2.5).normal();
    EXPECT_NEAR(chord(ChordMethod::rad_center), (te_centre - le_centre).norm() + 4.126 + 0.71, 5e-4);
    // They are not the same thing: between the smallest and the largest lies more than a millimetre.
    EXPECT_GT(std::abs(chord(ChordMethod::caliper) - chord(ChordMethod::nose_tail)), 0.05);
    EXPECT_GT(chord(ChordMethod::largest) - chord(ChordMethod::caliper), 0.05);
    EXPECT_GE(chord(ChordMethod::min_circle), chord(ChordMethod::largest) - 1e-9);
    EXPECT_NEAR(value_of(measure_stagger(section, StaggerMethod::caliper)), truth.caliper().angle, 1e-5);
    EXPECT_NEAR(value_of(measure_stagger(section, StaggerMethod::nose_tail)), truth.stagger(), 3e-5);
}

TEST(Characteristics, EdgesAtADistance) {
    for (const auto family : families::all_families) {
        const auto blade = section_truth::of_family(families::make(family, 12));
        const SectionTruth truth(blade);
        const SectionFit fit = fit_of(blade, 1.0, {400, 900, 400, 900});
        MeasuredSection section(fit);
        const double chord = (truth.tail() - truth.nose()).norm();
        for (const bool le : {true, false}) {
            const EdgeName edge = le ? EdgeName::le : EdgeName::te;
            for (const double share : {0.06, 0.15, 0.4})
                EXPECT_NEAR(value_of(measure_edge_thickness(section, edge, share * chord)),
                            truth.edge_thickness(le, share * chord), 5e-4)
                    << blade.name << " " << le << " " << share;
            const double angle = truth.edge_angle(le, 0.05 * chord, 0.2 * chord);
            EXPECT_NEAR(value_of(measure_edge_angle(section, edge, 0.05 * chord, 0.2 * chord, AngleReference::x_axis)),
                        angle, 5e-5);
            EXPECT_NEAR(std::remainder(value_of(measure_edge_angle(section, edge, 0.05 * chord, 0.2 * chord,
                                                                   AngleReference::chord)) -
                                           (angle - truth.stagger()),
                                       2 * std::numbers::pi),
                        0.0, 5e-5);
        }
        EXPECT_FALSE(measure_edge_thickness(section, EdgeName::le, 2.0 * chord));
    }
}

/// Between the cubic at the nose and the first circle, or past it, there is no distance without a place.
TEST(Characteristics, EveryDistanceFromTheEdgeHasItsPlace) {
    // Of the turbine of the second seed the first circle stands 0.8 mm behind where circles may begin.
    for (const std::uint64_t seed : {12U, 5U}) {
        for (const auto family : families::all_families) {
            const auto blade = section_truth::of_family(families::make(family, seed));
            const SectionTruth truth(blade);
            const SectionFit fit = fit_of(blade, 1.0, {400, 900, 400, 900});
            MeasuredSection section(fit);
            const double chord = (truth.tail() - truth.nose()).norm(), step = 1e-4 * chord;
            for (const bool le : {true, false}) {
                for (int k = 50; k < 900; ++k) {
                    const auto thickness = measure_edge_thickness(section, le ? EdgeName::le : EdgeName::te, k * step);
                    ASSERT_TRUE(thickness) << blade.name << " " << k * step << ": " << thickness.error().message;
                    if (k < 100 || k % 10 != 0) continue;  // nearer the truth's own search finds the other edge
                    EXPECT_NEAR(value_of(thickness), truth.edge_thickness(le, k * step), 1e-3)
                        << blade.name << " " << k * step;
                }
            }
        }
    }
}

/// A bump as of dirt and a groove on the suction side: elsewhere the camber line stays, and its end points with it.
TEST(Characteristics, CamberLineSurvivesABumpAndAGroove) {
    const auto plain = section_truth::envelope(50.0, 4.5, 25 * degree, 0.5, 0.3);
    auto spoilt = plain;
    spoilt.at = [plain](double t) {
        auto jet = plain.at(t);
        const auto bell = [&](double middle, double height, double width) {
            const double u = (t - middle) / width;
            return std::abs(u) < 1.0 ? height * std::pow(1.0 - u * u, 3) : 0.0;
        };
        const Vec2 normal = jet.normal();
        jet.position += (bell(3.3, 0.08, 0.03) - bell(3.6, 0.06, 0.04)) * normal;
        return jet;
    };
    const SectionFit clean = fit_of(plain), dirty = fit_of(spoilt, 0.25);
    MeasuredSection a(clean), b(dirty);
    ASSERT_TRUE(a.camber() && b.camber());
    EXPECT_LT((a.camber()->le().point() - b.camber()->le().point()).norm(), 0.02);
    EXPECT_LT((a.camber()->te().point() - b.camber()->te().point()).norm(), 0.02);
    EXPECT_NEAR(value_of(measure_chord(b, ChordMethod::nose_tail)), value_of(measure_chord(a, ChordMethod::nose_tail)),
                0.01);
    EXPECT_NEAR(a.camber()->length_mm(), b.camber()->length_mm(), 0.05);
}

/// Blades of compressors and of an engine, with facets, fillets and cooling slots: a camber line all the same, and no
/// circle between its sides is larger than the one that was found.
TEST(Characteristics, RealBladesHaveACamberLine) {
    std::vector<truth::Outline> outlines = truth::rotor37_outlines();
    for (const auto& more : {truth::hannover_outlines(), truth::engine_outlines()})
        outlines.insert(outlines.end(), more.begin(), more.end());
    if (outlines.empty()) GTEST_SKIP() << "../shared/data is absent";
    for (const auto& outline : outlines) {
        truth::ScanOptions scanning;
        scanning.pitch = 0.16;
        scanning.noise = 0.0005;
        const auto scan = truth::scan(truth::ball_centres(outline, 1.0), scanning);
        const auto fit = fit_section(scan.points, {}, {});
        ASSERT_TRUE(fit) << outline.name << ": " << fit.error().message;
        MeasuredSection section(*fit);
        const auto& camber = section.camber();
        ASSERT_TRUE(camber) << outline.name << ": " << camber.error().message;
        const auto thickest = camber->thickest();
        const double texture = outline.name.starts_with("engine") ? 0.010 : 0.002;  // of the mesh; of the others none
        double largest = 0.0;
        for (const InscribedCircle& circle : camber->circles())
            largest = std::max(largest, -outline.distance(circle.centre));
        EXPECT_NEAR(-outline.distance(thickest.circle.centre), thickest.circle.radius, texture) << outline.name;
        EXPECT_LT(largest, thickest.circle.radius + texture) << outline.name;
        EXPECT_NEAR(largest_inscribed_diameter(fit->contour), 2.0 * thickest.circle.radius, texture) << outline.name;
        const auto chord = measure_chord(section, ChordMethod::nose_tail);
        const auto longest = measure_chord(section, ChordMethod::largest);
        ASSERT_TRUE(chord && longest) << outline.name;
        EXPECT_LE(chord->value, longest->value) << outline.name;
        EXPECT_GT(chord->value, 0.95 * longest->value) << outline.name;
    }
}

/// The smallest distance of the moved outline to the outline, by a grid and halving of its step.
double throat_by_force(const SectionTruth& truth, const Vec2& pitch) {
    double best = 1e9, at = 0.0;
    const auto look = [&](double t) {
        const double distance = truth.distance(truth.section().at(std::fmod(t + 4.0, 4.0)).position + pitch);
        if (distance < best) std::tie(best, at) = std::pair(distance, t);
    };
    for (int k = 0; k < 400; ++k)
        look(0.01 * k);
    for (double step = 0.005; step > 1e-9; step *= 0.5) {
        const double from = at;
        look(from - step);
        look(from + step);
    }
    return best;
}

TEST(Characteristics, ThroatOfACascade) {
    for (const auto& [section, pitch] :
         {std::pair{like_ls89(), Vec2(0.0, 57.5)}, std::pair{like_ls89(), Vec2(3.0, 40.0)}}) {
        const SectionTruth truth(section);
        const SectionFit fit = fit_of(section);
        MeasuredSection measured(fit);
        const auto throat = measure_throat(measured, pitch);
        ASSERT_TRUE(throat) << throat.error().message;
        EXPECT_NEAR(throat->value, throat_by_force(truth, pitch), 2.0 * tenth_um);
        EXPECT_NEAR(measure_throat(measured, -pitch)->value, throat->value, 1e-6) << "the neighbour on the other side";
        // Material on both walls takes it away twice.
        double sum = 0.0;
        for (const auto& [point, weight] : throat->slopes.parts())
            sum += weight;
        EXPECT_NEAR(sum, -2.0, 1e-9);
        EXPECT_FALSE(measure_throat(measured, 0.05 * pitch)) << "blades that cross";
    }
}

/// A blade from one scan without bad points.
core::Result<SectionFit> scanned(const families::Blade& blade, std::uint64_t seed) {
    families::ScanOptions scanning;
    scanning.bad_share = 0.0;
    scanning.seed = seed;
    SectionOptions options;
    options.le_hint = blade.le().nose;
    options.te_hint = blade.te().nose;
    return fit_section(families::scan(blade, scanning).points, {}, options);
}

/// Two places of a passage may be nearly as narrow as each other, and one that is far narrower than the points are
/// apart is no less a passage.
TEST(Characteristics, ThroatOfTurbinesIsTheNarrowestPlaceOfAll) {
    for (const std::uint64_t seed : {48, 360}) {
        const auto blade = families::make(families::Family::turbine, seed);
        const SectionTruth truth(section_truth::of_family(blade));
        const auto fit = scanned(blade, 7919 * seed);
        ASSERT_TRUE(fit);
        MeasuredSection measured(*fit);
        const Vec2 pitch(0.0, 0.9 * (truth.tail() - truth.nose()).norm());
        const auto throat = measure_throat(measured, pitch);
        ASSERT_TRUE(throat) << throat.error().message;
        EXPECT_NEAR(throat->value, throat_by_force(truth, pitch), 1.5e-3) << seed;
    }
}

/// A trailing edge that comes out again on the other side of its neighbour: there is a distance, but no passage.
TEST(Characteristics, NoThroatWhereANeighbourReachesThroughTheBlade) {
    const auto blade = families::make(families::Family::turbine, 96);
    const auto fit = scanned(blade, families::ScanOptions().seed);
    ASSERT_TRUE(fit);
    MeasuredSection measured(*fit);
    const double chord = blade.shape().chord;
    EXPECT_FALSE(measure_throat(measured, {0.0, 0.9 * chord}));
    EXPECT_TRUE(measure_throat(measured, {0.0, 1.2 * chord}));
}

TEST(Characteristics, BestFitFindsAMotion) {
    const auto nominal_blade = section_truth::of_family(families::make(families::Family::compressor, 4));
    std::vector<Vec2> nominal_points;
    for (int k = 0; k < 6000; ++k)
        nominal_points.push_back(nominal_blade.at(k * (4.0 / 6000)).position);
    const auto nominal = ClosedCurve::through(nominal_points);
    ASSERT_TRUE(nominal);
    const double turn = 0.35 * degree;
    const Vec2 shift(0.06, -0.09);
    const SectionTruth truth(nominal_blade);
    // About the nominal's centre of area, then moved.
    const Eigen::Rotation2Dd rotation(turn);
    const Vec2 move = truth.centroid() + shift - rotation * truth.centroid();
    const SectionFit fit = fit_of(section_truth::placed(nominal_blade, turn, move));
    const ContourGeometry contour(fit.contour);
    const auto found = fit_to_nominal(contour, *nominal);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_NEAR(found->motion.turn_rad, turn, 1e-6);
    EXPECT_NEAR(found->motion.shift_mm.x(), shift.x(), tenth_um);
    EXPECT_NEAR(found->motion.shift_mm.y(), shift.y(), tenth_um);
    EXPECT_LT((found->motion.about_mm - truth.centroid()).norm(), 5e-3);
    EXPECT_LT(found->rms_mm, 2e-4);
    BestFitOptions held;
    held.rotate = false;
    const auto moved_only = fit_to_nominal(contour, *nominal, held);
    ASSERT_TRUE(moved_only);
    EXPECT_EQ(moved_only->motion.turn_rad, 0.0);
    EXPECT_GT(moved_only->rms_mm, 10 * found->rms_mm);
    std::vector<char> nothing(fit.contour.size(), 0);
    EXPECT_FALSE(fit_to_nominal(contour, *nominal, {}, nothing));
}

TEST(Characteristics, ARoundNominalDoesNotTellTheTwist) {
    std::vector<ContourPoint> contour(800);
    std::vector<Vec2> circle;
    for (int k = 0; k < 800; ++k) {
        const double a = 2 * std::numbers::pi * k / 800;
        contour[static_cast<std::size_t>(k)].normal = {std::cos(a), std::sin(a)};
        contour[static_cast<std::size_t>(k)].position_mm = 10.0 * contour[static_cast<std::size_t>(k)].normal;
        contour[static_cast<std::size_t>(k)].arc_length_mm = 10.0 * a;
        circle.push_back(contour[static_cast<std::size_t>(k)].position_mm);
    }
    const auto nominal = ClosedCurve::through(circle);
    ASSERT_TRUE(nominal);
    const auto fit = fit_to_nominal(ContourGeometry(contour), *nominal);
    ASSERT_FALSE(fit);
    EXPECT_EQ(fit.error().code, core::ErrorCode::fit_not_evaluable);
}

TEST(Characteristics, KeywordsOfTheField) {
    EXPECT_EQ(chord_method_from("NOSETAIL"), ChordMethod::nose_tail);
    EXPECT_EQ(chord_method_from("Tangent"), ChordMethod::caliper);
    EXPECT_EQ(chord_method_from("caliper"), ChordMethod::caliper);
    EXPECT_EQ(chord_method_from("mincircle"), ChordMethod::min_circle);
    EXPECT_FALSE(chord_method_from("wide"));
    EXPECT_EQ(stagger_method_from("CALIPER"), StaggerMethod::caliper);
    EXPECT_FALSE(stagger_method_from("XAXIS"));
}

}  // namespace
}  // namespace cmm::fitting
