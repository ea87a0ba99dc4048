// SPDX-License-Identifier: Apache-2.0
#include "acquisition/evaluation.hpp"

#include <gtest/gtest.h>

#include <cmath>

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
    return evaluate_section(std::move(raw), std::move(fit), synthetic::positions(section.contour()), options);
}

TEST(Decision, HasThreeStatesWithAGuardBand) {
    EXPECT_NEAR(guard_band_mm(0.010), 0.00825, 1e-12);
    EXPECT_EQ(decide(0.0917, 0.010, 0.100), Decision::accept);
    EXPECT_EQ(decide(0.0918, 0.010, 0.100), Decision::undecided);
    EXPECT_EQ(decide(0.1082, 0.010, 0.100), Decision::undecided);
    EXPECT_EQ(decide(0.1083, 0.010, 0.100), Decision::reject);
    EXPECT_EQ(decide(0.100, 0.0, 0.100), Decision::accept);
}

TEST(Evaluation, AUniformOffsetIsFoundEverywhere) {
    for (const double offset : {-0.05, 0.0, 0.012, 0.2}) {
        const auto result = judged([&](const auto&) { return offset; }, limits());
        ASSERT_EQ(result.deviation_mm.size(), result.fit->contour.size());
        for (std::size_t i = 0; i < result.deviation_mm.size(); ++i) {
            ASSERT_NEAR(result.deviation_mm[i], offset, 0.0005) << "point " << i << " offset " << offset;
        }
        for (const auto* name : {"profile_le", "profile_suction", "profile_te", "profile_pressure"}) {
            const auto* c = result.find(name);
            ASSERT_NE(c, nullptr);
            EXPECT_NEAR(*c->value_mm, 2.0 * std::abs(offset), 0.001) << name;
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
        ASSERT_NEAR(result.deviation_mm[i], -0.6, 0.02) << "point " << i;
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
    EXPECT_NEAR(*result.find("profile_pressure")->value_mm, 0.212, 0.001);
    EXPECT_EQ(result.find("profile_suction")->decision, Decision::accept);
    EXPECT_EQ(*result.find("profile_suction")->limit_mm, 0.10);
    EXPECT_EQ(result.find("profile_te")->decision, Decision::undecided);
    EXPECT_EQ(*result.find("profile_te")->limit_mm, 0.06);
    EXPECT_NEAR(*result.find("profile_te")->u95_mm, 0.0024, nanometre);
    EXPECT_EQ(result.find("le_radius")->decision, Decision::reported);
    EXPECT_NEAR(*result.find("le_radius")->value_mm, 0.4, nanometre);
    EXPECT_EQ(result.decision(), Decision::reject);
    EXPECT_GT(result.rejected(), 0U);
}

TEST(Evaluation, LeanWidensTheUncertainty) {
    auto options = limits();
    options.ball_radius_mm = 1.0;
    options.lean_rad = core::rad_from_deg(10.0);
    const double error = 1.0 - std::cos(options.lean_rad);
    EXPECT_NEAR(error, 0.0152, 0.0001);
    const auto result = judged([](const auto&) { return 0.002; }, options);
    EXPECT_NEAR(*result.find("profile_suction")->u95_mm, 2.0 * (0.0007 + error), nanometre);
    EXPECT_NEAR(*result.find("te_radius")->u95_mm, 0.0021 + error, nanometre);
    EXPECT_NEAR(*result.find("max_thickness")->u95_mm, std::sqrt(2.0) * 0.0007 + 2.0 * error, nanometre);
    EXPECT_NE(result.find("profile_suction")->note.find("2-D offset error"), std::string::npos);
}

TEST(Evaluation, WithoutANominalThereIsNothingToJudge) {
    const Shape shape;
    auto fit = fit_of(Section(shape), shape, [](const auto&) { return 0.0; });
    fit.te.valid = false;
    fit.te.why = "arc of 40 deg is too short";
    const auto result = evaluate_section({}, std::move(fit), {}, limits());
    EXPECT_EQ(result.find("profile_le"), nullptr);
    EXPECT_EQ(result.find("te_radius")->decision, Decision::not_evaluable);
    EXPECT_EQ(result.find("te_radius")->note, "arc of 40 deg is too short");
    EXPECT_NEAR(*result.find("chord")->value_mm, (Section(shape).nose() - Section(shape).tail()).norm(), nanometre);
    EXPECT_EQ(result.decision(), Decision::reported);
    PartResult part;
    part.sections = {result};
    EXPECT_EQ(part.verdict(), Decision::accept) << "done";
    EXPECT_FALSE(part.has_requirements());
}

TEST(Evaluation, AnOpenSectionIsNotEvaluable) {
    const auto nominal = synthetic::positions(Section(Shape{}).contour());
    const auto failed =
        evaluate_section({}, core::fail(core::ErrorCode::fit_not_evaluable, "gap of 3.000 mm"), nominal, limits());
    EXPECT_EQ(failed.why, "gap of 3.000 mm");
    ASSERT_EQ(failed.characteristics.size(), 8U);
    for (const auto& c : failed.characteristics) {
        EXPECT_EQ(c.decision, Decision::not_evaluable) << c.name;
        EXPECT_EQ(c.note, "gap of 3.000 mm");
        EXPECT_FALSE(c.value_mm);
    }
    EXPECT_EQ(failed.decision(), Decision::undecided);
    EXPECT_EQ(evaluate_section({}, fitting::SectionFit{}, nominal, limits()).decision(), Decision::undecided);
}

TEST(Verdict, TheWorstDecisionWinsAndSaysWhy) {
    auto good = judged([](const auto&) { return 0.002; }, limits());
    auto bad = judged([](const auto& p) { return p.zone == Zone::pressure ? 0.106 : 0.002; }, limits());
    bad.index = 3;
    const auto open = evaluate_section({}, core::fail(core::ErrorCode::fit_not_evaluable, "open"), {}, limits());
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
    EXPECT_EQ(reasons[0], "section 3 (z 40.0): profile_pressure 0.212 mm +- 0.001 mm > 0.100 mm");
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
