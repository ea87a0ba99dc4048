// SPDX-License-Identifier: Apache-2.0
#include "acquisition/evaluation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fitting/offset.hpp"
#include "fitting/offset_spline.hpp"
#include "tests/acquisition/synthetic_blade.hpp"

namespace cmm::acquisition {
namespace {

using fitting::Zone;
using synthetic::fit_of;
using synthetic::Section;
using synthetic::Shape;

constexpr double nanometre = 1e-6;

EvaluationOptions limits() {
    EvaluationOptions options;
    options.profile_mm = 0.10;
    options.edge_profile_mm = 0.06;
    return options;
}

template <class Deviation>
SectionResult judged(const Deviation& deviation, const EvaluationOptions& options) {
    const Shape shape;
    const Section section(shape);
    auto fit = fit_of(section, shape, deviation);
    SectionResult raw;
    raw.z_mm = 40.0;
    raw.points = synthetic::points_of(fit, 1.0, 40.0, 1, 50, 5);
    const auto nominal = synthetic::reference(section, 0.0);
    return evaluate_section(std::move(raw), std::move(fit), &nominal, options);
}

TEST(Evaluation, AUniformOffsetIsFoundEverywhere) {
    for (const double offset : {-0.05, 0.0, 0.012, 0.2}) {
        const auto result = judged([&](const auto&) { return offset; }, limits());
        ASSERT_EQ(result.deviation_mm.size(), result.fit->contour.size());
        for (std::size_t i = 0; i < result.deviation_mm.size(); ++i) {
            ASSERT_NEAR(result.deviation_mm[i].value(), offset, 0.0005) << "point " << i << " offset " << offset;
        }
        for (const auto* name : {"profile_le", "profile_suction", "profile_te", "profile_pressure"}) {
            const auto* c = result.find(name);
            ASSERT_NE(c, nullptr);
            EXPECT_NEAR(*c->value, 2.0 * std::abs(offset), 0.001) << name;
        }
    }
}

TEST(Evaluation, AThinEdgeIsNotComparedWithItsOtherSide) {
    // Each side moved by more than the thickness of the trailing edge: the nearer curve is the wrong one.
    const auto result = judged([](const auto& point) { return point.zone == Zone::suction ? -0.6 : 0.0; }, limits());
    const auto& contour = result.fit->contour;
    std::size_t checked = 0;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const bool near_te = (contour[i].position_mm - result.fit->te_point_mm).norm() < 4.0;
        if (contour[i].zone != Zone::suction || !near_te) continue;
        if ((contour[i].position_mm - result.fit->te_point_mm).norm() < 1.5) continue;  // beside the arc itself
        ++checked;
        ASSERT_NEAR(result.deviation_mm[i].value(), -0.6, 0.02) << "point " << i;
    }
    EXPECT_GT(checked, 20U);
}

TEST(Evaluation, EachZoneHasItsLimitAndItsDecision) {
    const auto result = judged(
        [](const auto& point) {
            if (point.zone == Zone::pressure) return 0.106;
            if (point.zone == Zone::te) return 0.0295;
            return 0.010;
        },
        limits());
    EXPECT_EQ(result.find("profile_pressure")->decision, Decision::reject);
    EXPECT_NEAR(*result.find("profile_pressure")->value, 0.212, 0.001);
    EXPECT_EQ(result.find("profile_suction")->decision, Decision::accept);
    EXPECT_EQ(*result.find("profile_suction")->upper, 0.10);
    EXPECT_EQ(result.find("profile_te")->decision, Decision::undecided);
    EXPECT_EQ(*result.find("profile_te")->upper, 0.06);
    // The worst place of a zone is the largest of some 392/12 values of the noise: 3.17 standard deviations.
    EXPECT_NEAR(*result.find("profile_te")->u95, 3.17 * 0.0012, 0.01 * 0.0012);
    EXPECT_EQ(result.find("le_radius")->decision, Decision::reported);
    EXPECT_NEAR(*result.find("le_radius")->value, 0.4, nanometre);
    EXPECT_EQ(result.decision(), Decision::reject);
    EXPECT_GT(result.rejected(), 0U);
}

TEST(Evaluation, LeanWidensTheUncertainty) {
    const double lean = core::rad_from_deg(10.0), error = 1.0 / std::cos(lean) - 1.0;
    EXPECT_NEAR(error, 0.0154, 0.0001);
    const Shape shape;
    const Section section(shape);
    NominalContour leaning{40.0, synthetic::positions(section.contour()), lean, {}};
    const auto evaluated = [&] {
        const ReferenceContour nominal(leaning, fitting::ClosedCurve::through(leaning.points).value(), 1.0);
        return evaluate_section({}, fit_of(section, shape, [](const auto&) { return 0.002; }), &nominal, limits());
    };
    const auto result = evaluated();
    EXPECT_NEAR(*result.find("profile_suction")->u95, 2.0 * (0.0007 + error), nanometre);
    EXPECT_NEAR(*result.find("te_radius")->u95, 0.0021 + std::sqrt(1.2) * error, nanometre);
    EXPECT_NEAR(*result.find("max_thickness")->u95, std::sqrt(2.0) * 0.0007 + 2.0 * error, nanometre);
    EXPECT_NE(result.find("profile_suction")->note.find("2-D offset error"), std::string::npos);
    // Where it is known point by point, each has its own.
    const auto contour = section.contour();
    for (const auto& point : contour)
        leaning.leans_rad.push_back(point.zone == Zone::pressure ? lean : 0.0);
    const auto sides = evaluated();
    EXPECT_NEAR(*sides.find("profile_pressure")->u95, 2.0 * (0.0007 + error), nanometre);
    EXPECT_NEAR(*sides.find("profile_suction")->u95, 2.0 * 0.0007, nanometre);
    EXPECT_NEAR(*sides.find("te_radius")->u95, 0.0021, nanometre);
    std::size_t wrong = 0;
    for (const auto& point : sides.fit->contour)
        wrong += std::abs(point.offset_error_mm - (point.zone == Zone::pressure ? error : 0.0)) > nanometre ? 1 : 0;
    EXPECT_LE(wrong, 4U) << "only where the zones meet";
    // A blade that leans across its chord stands upright at the nose, and its edge is measured too round all the same.
    leaning.leans_rad.clear();
    const Eigen::Vector2d along = (section.tail() - section.nose()).normalized();
    for (const auto& point : contour)
        leaning.leans_rad.push_back(lean * (1.0 - std::pow(point.normal.dot(along), 2)));
    const auto across = evaluated();
    EXPECT_LT(nearest_to(across.fit->contour, across.fit->te_point_mm).offset_error_mm, 0.05 * error);
    EXPECT_GT(*across.find("te_radius")->u95, 0.0021 + 0.5 * error);
}

TEST(Evaluation, WhatIsNotKnownOfALeanWidensSizesAndRadii) {
    constexpr double doubt = 0.003;
    const Shape shape;
    const Section section(shape);
    auto fit = fit_of(section, shape, [](const auto&) { return 0.002; });
    for (auto& point : fit.contour) {
        point.bound_mm = doubt;
        point.u95_mm += doubt;
    }
    const NominalContour nominal{40.0, synthetic::positions(section.contour()), 0.0, {}};
    const ReferenceContour reference(nominal, fitting::ClosedCurve::through(nominal.points).value(), 1.0);
    const auto result = evaluate_section({}, fit, &reference, limits());
    EXPECT_NEAR(*result.find("max_thickness")->u95, std::sqrt(2.0) * 0.0007 + 2.0 * doubt, nanometre);
    // As wide as if all of the edge were off by it, at least: what is not known has no sign.
    EXPECT_GT(*result.find("te_radius")->u95, 0.0021 + std::sqrt(1.2) * doubt - nanometre);
    EXPECT_LT(*result.find("te_radius")->u95, 0.0021 + 4.0 * doubt);
}

fitting::PiecewiseCubic polygon(const std::vector<Eigen::Vector2d>& corners) {
    std::vector<fitting::PiecewiseCubic::Piece> sides;
    std::vector<double> breaks{0.0};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Eigen::Vector2d side = corners[(i + 1) % corners.size()] - corners[i];
        sides.push_back({corners[i], side.normalized(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()});
        breaks.push_back(breaks.back() + side.norm());
    }
    return {breaks, sides, true};
}

/// What the ball touches of a part (20 mm long, 4 mm thick) that is thicker everywhere.
fitting::SectionFit touched(const fitting::PiecewiseCubic& outline, double ball_radius_mm, double thicker_mm) {
    fitting::SectionFit fit;
    const auto centres = fitting::offset_spline(outline, ball_radius_mm + thicker_mm, 1e-6).curve;
    for (const auto& p : fitting::offset_inwards(centres, ball_radius_mm, 6000).points) {
        fitting::ContourPoint point;
        point.position_mm = p.position;
        point.normal = p.normal;
        const double x = p.position.x();
        point.zone = x > 19.5 ? Zone::te : x < 0.2 ? Zone::le : p.position.y() > 1.0 ? Zone::suction : Zone::pressure;
        fit.contour.push_back(point);
    }
    return fit;
}

bool beside_a_corner(const std::vector<Eigen::Vector2d>& corners, const Eigen::Vector2d& at) {
    return std::any_of(corners.begin(), corners.end(), [&](const auto& corner) { return (corner - at).norm() < 0.02; });
}

/// A step of a millimetre in a side: the ball rests on its foot and on its wall, and only there nothing is compared.
TEST(Evaluation, WhereTheBallDoesNotReachNothingIsCompared) {
    const NominalContour part{
        0.0, {{0, 0}, {20, -0.5}, {20.3, 0}, {20, 0.5}, {12, 3}, {12, 4}, {0, 4.3}, {-0.3, 2}}, 0.0, {}};
    const fitting::PiecewiseCubic outline = polygon(part.points);
    const double r = 0.4, thicker = 0.005;
    const ReferenceContour nominal(part, fitting::ClosedCurve(outline), r);
    ASSERT_EQ(nominal.hollows().size(), 1U);
    const auto& hollow = nominal.hollows()[0];
    EXPECT_NEAR(hollow.centre.x(), 12.0 + r, 1e-9);

    // Measured: what the ball touches of a part that is 5 um thicker everywhere.
    auto fit = touched(outline, r, thicker);
    const auto in_hollow =
        static_cast<std::size_t>(std::count_if(fit.contour.begin(), fit.contour.end(),
                                               [&](const auto& p) { return hollow.bridges(p.position_mm, p.normal); }));
    EXPECT_GT(in_hollow, 20U);
    const auto result = evaluate_section({}, fit, &nominal, limits());
    EXPECT_EQ(result.not_reached(), in_hollow);
    for (std::size_t i = 0; i < fit.contour.size(); ++i) {
        const auto& at = fit.contour[i].position_mm;
        const double d = result.deviation_mm[i].value_or(thicker);
        EXPECT_NEAR(d, thicker, beside_a_corner(part.points, at) ? 1e-3 : 2e-6) << at.transpose();
    }
    EXPECT_NEAR(*result.find("profile_suction")->value, 2.0 * thicker, 1e-5);
    EXPECT_NE(result.find("profile_suction")->note.find("the ball does not reach"), std::string::npos);
    EXPECT_EQ(result.find("profile_pressure")->note.find("the ball does not reach"), std::string::npos);
    // Where the fit itself knows that the ball rests in a hollow nothing is compared either.
    for (auto& point : fit.contour)
        point.reached = point.zone != Zone::suction;
    const auto bridged = evaluate_section({}, fit, &nominal, limits());
    EXPECT_EQ(bridged.find("profile_suction")->decision, Decision::not_evaluable);
    EXPECT_EQ(bridged.find("profile_pressure")->decision, Decision::accept);
}

/// The contour across a filled groove is shorter than the nominal's: what follows is compared with its own place.
TEST(Evaluation, AfterAFilledGrooveTheComparisonGoesOn) {
    const std::vector<Eigen::Vector2d> filled{{0, 0}, {20, -0.5}, {20.3, 0}, {20, 0.5}, {14, 3}, {11, 3.4}, {-0.3, 2}};
    NominalContour part{0.0, filled, 0.0, {}};
    part.points.insert(part.points.begin() + 5, {{14, 2}, {11, 2}});
    const double r = 0.4;
    const ReferenceContour nominal(part, fitting::ClosedCurve(polygon(part.points)), r);
    auto fit = touched(polygon(filled), r, 0.0);
    const auto deviations = nominal.compare(fit.contour);
    double filling = 0.0;
    for (std::size_t i = 0; i < deviations.size(); ++i) {
        const auto& at = fit.contour[i].position_mm;
        const bool above_groove = at.x() > 10.9 && at.x() < 14.1 && at.y() > 1.0;
        if (above_groove) filling = std::max(filling, deviations[i].value_or(0.0));
        if (above_groove) continue;
        ASSERT_TRUE(deviations[i]) << at.transpose();
        EXPECT_NEAR(*deviations[i], 0.0, 2e-6) << at.transpose();
    }
    EXPECT_GT(filling, 0.9);
}

/// Facets make hollows of micrometres: there the ball's arc is the nominal, and nothing is left out.
TEST(Evaluation, AShallowHollowIsComparedWithTheBall) {
    const std::vector<Eigen::Vector2d> bent{{0, 0}, {20, -0.5}, {20.3, 0}, {20, 0.5}, {12, 1.3}, {0, 4.3}, {-0.3, 2}};
    const double r = 1.0, thicker = 0.005;
    const ReferenceContour nominal({0.0, bent, 0.0, {}}, fitting::ClosedCurve(polygon(bent)), r);
    ASSERT_EQ(nominal.hollows().size(), 1U);
    ASSERT_LT(nominal.hollows()[0].depth_mm, 0.005);
    auto fit = touched(polygon(bent), r, thicker);
    const auto deviations = nominal.compare(fit.contour);
    for (std::size_t i = 0; i < deviations.size(); ++i) {
        const auto& at = fit.contour[i].position_mm;
        ASSERT_TRUE(deviations[i]) << at.transpose();
        if (beside_a_corner(bent, at)) continue;
        EXPECT_NEAR(*deviations[i], thicker, 2e-5) << at.transpose();
    }
}

/// Waviness of 1 mm in the middle, below a cut-off of 4 mm: the filtered profile does not see it, and says which filter
/// it went through.
TEST(Evaluation, AFilterJudgesTheSidesOnly) {
    EvaluationOptions options = limits();
    options.filters.at(Zone::suction) = options.filters.at(Zone::pressure) = {fitting::FilterKind::gaussian, 4.0};
    const auto wave = [](const fitting::ContourPoint& point) {
        const double s = point.arc_length_mm - 95.0;  // from the middle of the suction side: its ends are smooth
        return 0.02 + 0.01 * std::exp(-0.02 * s * s) * std::cos(2.0 * std::numbers::pi * s);
    };
    const auto plain = judged(wave, limits()), filtered = judged(wave, options);
    EXPECT_NEAR(*plain.find("profile_suction")->value, 2 * 0.03, 5e-4);  // the crest lies between two points
    EXPECT_NEAR(*filtered.find("profile_suction")->value, 2 * 0.02, 2e-4);
    EXPECT_EQ(*filtered.find("profile_le")->value, *plain.find("profile_le")->value);
    EXPECT_NE(filtered.find("profile_suction")->method.find("ISO 16610-21, cut-off 4.000 mm"), std::string::npos);
    EXPECT_EQ(filtered.find("profile_le")->method.find("16610"), std::string::npos);
    EXPECT_EQ(plain.deviation_mm, filtered.deviation_mm) << "what was measured is kept";
    options.filters.at(Zone::te) = {fitting::FilterKind::spline, 50.0};
    const auto refused = judged(wave, options);
    EXPECT_EQ(refused.find("profile_te")->decision, Decision::not_evaluable);
    EXPECT_NE(refused.find("profile_te")->note.find("shorter than the cut-off"), std::string::npos);
}

TEST(Evaluation, WithoutANominalThereIsNothingToJudge) {
    const Shape shape;
    auto fit = fit_of(Section(shape), shape, [](const auto&) { return 0.0; });
    fit.te.valid = false;
    fit.te.why = "arc of 40 deg is too short";
    const auto result = evaluate_section({}, std::move(fit), nullptr, limits());
    EXPECT_EQ(result.find("profile_le"), nullptr);
    EXPECT_EQ(result.find("te_radius")->decision, Decision::not_evaluable);
    EXPECT_EQ(result.find("te_radius")->note, "arc of 40 deg is too short");
    EXPECT_NEAR(*result.find("chord")->value, (Section(shape).nose() - Section(shape).tail()).norm(), nanometre);
    EXPECT_EQ(result.decision(), Decision::reported);
    PartResult part;
    part.sections = {result};
    EXPECT_EQ(part.verdict(), Decision::accept) << "done";
    EXPECT_FALSE(part.has_requirements());
}

TEST(Evaluation, AnOpenSectionIsNotEvaluable) {
    const auto nominal = synthetic::reference(Section(Shape{}), 0.0);
    const auto failed =
        evaluate_section({}, core::fail(core::ErrorCode::fit_not_evaluable, "gap of 3.000 mm"), &nominal, limits());
    EXPECT_EQ(failed.why, "gap of 3.000 mm");
    ASSERT_EQ(failed.characteristics.size(), 8U);
    for (const auto& c : failed.characteristics) {
        EXPECT_EQ(c.decision, Decision::not_evaluable) << c.name;
        EXPECT_EQ(c.note, "gap of 3.000 mm");
        EXPECT_FALSE(c.value);
    }
    EXPECT_EQ(failed.decision(), Decision::undecided);
    EXPECT_EQ(evaluate_section({}, fitting::SectionFit{}, &nominal, limits()).decision(), Decision::undecided);
}

TEST(Verdict, TheWorstDecisionWinsAndSaysWhy) {
    auto good = judged([](const auto&) { return 0.002; }, limits());
    auto bad = judged([](const auto& p) { return p.zone == Zone::pressure ? 0.106 : 0.002; }, limits());
    bad.index = 3;
    const auto open = evaluate_section({}, core::fail(core::ErrorCode::fit_not_evaluable, "open"), nullptr, limits());
    PartResult part;
    EXPECT_EQ(part.verdict(), Decision::undecided);
    part.sections = {good};
    EXPECT_EQ(part.verdict(), Decision::accept);
    EXPECT_TRUE(verdict_reasons(part).empty());
    part.complete = false;
    EXPECT_EQ(part.verdict(), Decision::undecided);
    part.sections = {good, bad};
    EXPECT_EQ(part.verdict(), Decision::reject) << "an incomplete part can be rejected";
    part.complete = true;
    part.sections = {good, open};
    EXPECT_EQ(part.verdict(), Decision::undecided);
    part.sections = {open, good, bad};
    EXPECT_EQ(part.verdict(), Decision::reject);
    const auto reasons = verdict_reasons(part);
    ASSERT_EQ(reasons.size(), 2U);
    EXPECT_EQ(reasons[0], "section 3 (z 40.0): profile_pressure 0.212 mm +- 0.002 mm > 0.100 mm");
    EXPECT_EQ(reasons[1], "section 0 (z 0.0): open");
}

TEST(Verdict, OneLineForEachBadSection) {
    const auto number = [](const char* name, double value, Decision decision) {
        return Characteristic{name, "m", value, 0.004, 0.1, decision, {}};
    };
    const auto without = [](const char* name, const char* note) {
        return Characteristic{name, "m", {}, {}, 0.1, Decision::not_evaluable, note};
    };
    auto rejected = judged([](const auto&) { return 0.002; }, limits());
    auto open = rejected;
    auto mixed = rejected;
    rejected.characteristics = {
        number("profile_le", 0.131, Decision::reject), number("profile_suction", 0.02, Decision::accept),
        number("profile_te", 0.101, Decision::undecided), number("profile_pressure", 0.212, Decision::reject)};
    open.characteristics = {without("profile_le", "the ball cannot reach it"),
                            without("profile_suction", "the ball cannot reach it"), without("chord", "no edge")};
    mixed.characteristics = {without("profile_le", "no such zone"), number("profile_te", 0.099, Decision::undecided),
                             number("profile_pressure", 0.101, Decision::undecided)};
    PartResult part;
    part.sections = {open, rejected, mixed};
    EXPECT_EQ(verdict_reasons(part),
              (std::vector<std::string>{
                  "section 0 (z 40.0): profile_pressure 0.212 mm +- 0.004 mm > 0.100 mm; also profile_le 0.131 mm",
                  "section 0 (z 40.0): profile_le, profile_suction not evaluable: the ball cannot reach it; also chord "
                  "(no edge)",
                  "section 0 (z 40.0): profile_pressure 0.101 mm +- 0.004 mm is too near to 0.100 mm to decide; also "
                  "profile_te 0.099 mm, profile_le (no such zone)"}));
}

}  // namespace
}  // namespace cmm::acquisition
