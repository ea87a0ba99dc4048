// SPDX-License-Identifier: Apache-2.0
#include "acquisition/part_judge.hpp"

#include <algorithm>
#include <deque>
#include <string>

#include "tests/acquisition/leaning_part.hpp"
#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {
namespace {

using Method = Compensation::State;

struct PartJudgeTest : ::testing::Test {
    static std::string part_text(const std::string& heights, const std::string& fitting = "") {
        std::string text = session_part_text() + fitting;
        const std::string plain = "[20, 40]";
        return text.replace(text.find(plain), plain.size(), heights);
    }
    struct Measured {
        SessionPart job;
        std::deque<SectionSetup> setups;
        explicit Measured(const std::string& text) : job(text) {
            for (std::size_t i = 0; i < job.plan.paths.size(); ++i)
                setups.push_back(job.setup(i));
        }
        std::vector<RecordedPoint> points(std::size_t index) const {
            std::vector<RecordedPoint> points;
            for (const auto& planned : job.plan.paths[index].points) {
                RecordedPoint point;
                point.sequence = points.size() + 1;
                point.centre_mm = planned.centre_mm;
                points.push_back(point);
            }
            return points;
        }
    };
};

TEST_F(PartJudgeTest, ASectionIsFinalWhenTheOneAboveHasClosed) {
    const Measured measured(part_text("[20, 30, 40]"));
    PartJudge judge;
    EXPECT_EQ(judge.finish(measured.setups[0], measured.points(0)).compensation.state, Method::provisional);
    EXPECT_TRUE(judge.grow().empty());
    EXPECT_NE(judge.foretell(), nullptr) << "its lean is the nominal's";
    judge.finish(measured.setups[1], measured.points(1));
    for (std::size_t below : {0U, 1U}) {
        const auto revised = judge.grow();
        ASSERT_EQ(revised.size(), 1U);
        EXPECT_EQ(revised[0]->index, below);
        EXPECT_EQ(revised[0]->compensation.state, Method::final);
        EXPECT_EQ(revised[0]->characteristics.size(), 8U);
        const auto* newest = judge.foretell();
        ASSERT_NE(newest, nullptr);
        EXPECT_EQ(newest->index, below + 1);
        EXPECT_EQ(newest->compensation.state, Method::provisional);
        if (below == 0) judge.finish(measured.setups[2], measured.points(2));
    }
    const auto all = judge.complete();
    EXPECT_EQ(all.size(), 3U);
    for (const auto* section : all) {
        EXPECT_EQ(section->compensation.state, Method::final) << section->compensation.note;
        EXPECT_GE(section->compensation.change_mm, 0.0);
        EXPECT_GT(section->compensation.share, 0.5);
    }
}

double largest_u95_mm(const SectionResult& section) {
    double largest = 0.0;
    for (const auto& point : section.fit->contour)
        largest = std::max(largest, point.u95_mm);
    return largest;
}

/// Walls that lean by 10 degrees and more, with the twist: 15 to 18 um beside the 2-D contour.
TEST_F(PartJudgeTest, AProvisionalSectionLeansAsItsNominalAndHardlyChangesWhenItIsFinal) {
    const LeaningPart part(leaning_text("profile_mm = 0.1\n"), Eigen::Vector2d::Zero());
    PartJudge judge;
    for (const std::size_t index : {0U, 1U, 2U}) {
        const auto& flat = judge.finish(part.setups[index], part.points(index));
        EXPECT_EQ(flat.compensation.from_flat_mm, 0.0);
        const auto below = judge.grow();
        ASSERT_EQ(below.size(), index > 0 ? 1U : 0U);
        if (index > 0) {
            EXPECT_EQ(below[0]->compensation.state, Method::final);
            EXPECT_GT(below[0]->compensation.from_flat_mm, 14e-3);
            EXPECT_LT(below[0]->compensation.change_mm, 2e-3);
            EXPECT_LT(largest_u95_mm(*below[0]), 5e-3) << "two sections alone do not know their lean";
        }
        const auto* newest = judge.foretell();
        ASSERT_NE(newest, nullptr);
        EXPECT_EQ(newest->index, index);
        EXPECT_EQ(newest->compensation.state, Method::provisional);
        EXPECT_GT(newest->compensation.from_flat_mm, 14e-3);
        EXPECT_LT(newest->compensation.from_flat_mm, 19e-3);
        EXPECT_EQ(newest->compensation.change_mm, newest->compensation.from_flat_mm);
    }
}

/// The nominal's lean leaves 9 um.
TEST_F(PartJudgeTest, FromTheThirdSectionOnTheLeanIsMeasured) {
    const LeaningPart part(leaning_text("profile_mm = 0.1\n"), leans_more);
    PartJudge judge;
    for (const std::size_t index : {0U, 1U, 2U}) {
        judge.finish(part.setups[index], part.points(index));
        judge.grow();
        ASSERT_NE(judge.foretell(), nullptr);
    }
    judge.complete();
    const auto sections = judge.take();
    EXPECT_GT(sections[2].compensation.from_flat_mm, 20e-3);
    EXPECT_LT(sections[2].compensation.change_mm, 2e-3);
}

/// Of a nominal that knows how steep it is at most, and not where and which way.
TEST_F(PartJudgeTest, ALeanThatIsOnlyABoundForetellsNothing) {
    LeaningPart part(leaning_text("profile_mm = 0.1\n"), Eigen::Vector2d::Zero());
    const auto points = part.points(0);
    SectionSetup& setup = part.setups[0];
    ASSERT_TRUE(setup.nominal->reference.knows_lean());
    NominalContour contour;
    contour.points = setup.nominal->reference.points();
    contour.lean_rad = 0.2;
    setup.nominal->reference = ReferenceContour(contour, setup.nominal->section.curve(), setup.ball_radius_mm);
    EXPECT_FALSE(setup.nominal->reference.knows_lean());
    PartJudge judge;
    judge.finish(setup, points);
    EXPECT_TRUE(judge.grow().empty());
    EXPECT_EQ(judge.foretell(), nullptr);
}

TEST_F(PartJudgeTest, WithoutANominalTheFirstSectionStaysInItsPlaneUntilTheSecondHasClosed) {
    const LeaningPart part(leaning_text("profile_mm = 0.1\n"), leans_more);
    const auto setups = too_thick_without_nominal(part);
    PartJudge judge;
    judge.finish(setups[0], part.points(0));
    EXPECT_TRUE(judge.grow().empty());
    EXPECT_EQ(judge.foretell(), nullptr);
    judge.finish(setups[1], part.points(1));
    judge.grow();
    const auto* second = judge.foretell();
    ASSERT_NE(second, nullptr);
    EXPECT_EQ(second->compensation.state, Method::provisional);
    EXPECT_GT(second->compensation.from_flat_mm, 14e-3);
}

TEST_F(PartJudgeTest, TheEndDoesNotDependOnWhatWasJudgedBefore) {
    const Measured measured(part_text("[20, 30, 40]"));
    PartJudge live, late, shuffled;
    for (const std::size_t i : {0U, 1U, 2U}) {
        live.finish(measured.setups[i], measured.points(i));
        live.grow();
        live.foretell();
        late.finish(measured.setups[i], measured.points(i));
    }
    for (const std::size_t i : {1U, 2U, 0U}) {
        shuffled.finish(measured.setups[i], measured.points(i));
        shuffled.grow();
    }
    live.complete();
    late.complete();
    shuffled.complete();
    const auto a = live.take(), b = late.take(), c = shuffled.take();
    ASSERT_EQ(a.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
        ASSERT_EQ(a[i].fit->contour.size(), b[i].fit->contour.size());
        ASSERT_EQ(a[i].fit->contour.size(), c[i].fit->contour.size());
        EXPECT_EQ(a[i].deviation_mm, b[i].deviation_mm);
        EXPECT_EQ(a[i].deviation_mm, c[i].deviation_mm);
        for (std::size_t k = 0; k < a[i].fit->contour.size(); ++k) {
            ASSERT_EQ(a[i].fit->contour[k].position_mm, b[i].fit->contour[k].position_mm);
            ASSERT_EQ(a[i].fit->contour[k].u95_mm, b[i].fit->contour[k].u95_mm);
            ASSERT_EQ(a[i].fit->contour[k].position_mm, c[i].fit->contour[k].position_mm);
        }
    }
    EXPECT_TRUE(live.take().empty());
}

TEST_F(PartJudgeTest, TheEndCanBeReachedStepByStep) {
    const Measured measured(part_text("[20, 30, 40]"));
    PartJudge at_once, stepwise;
    for (std::size_t i = 0; i < 3; ++i) {
        at_once.finish(measured.setups[i], measured.points(i));
        stepwise.finish(measured.setups[i], measured.points(i));
    }
    EXPECT_FALSE(stepwise.completing());
    EXPECT_EQ(stepwise.complete_next(), nullptr);
    at_once.complete();
    EXPECT_TRUE(stepwise.begin_completion().empty());
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_TRUE(stepwise.completing());
        EXPECT_EQ(stepwise.complete_next()->index, i) << "upwards";
    }
    EXPECT_FALSE(stepwise.completing());
    EXPECT_EQ(stepwise.complete_next(), nullptr);
    const auto a = at_once.take(), b = stepwise.take();
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(a[i].deviation_mm, b[i].deviation_mm);
}

TEST_F(PartJudgeTest, TheMethodThatIsAskedForIsUsedAndSaid) {
    for (const auto name : fitting::compensation_method_names()) {
        const auto method = fitting::compensation_method_from(name).value();
        if (!fitting::is_point_by_point(method)) continue;
        const Measured measured(part_text("[20, 30, 40]", "[fitting]\ncompensation = \"" + std::string(name) + "\"\n"));
        EXPECT_EQ(measured.setups[0].fitting.compensation, method);
        PartJudge judge;
        const auto lonely = fitting::needs_neighbours(method) ? Method::provisional : Method::final;
        EXPECT_EQ(judge.finish(measured.setups[0], measured.points(0)).compensation.state, lonely) << name;
        EXPECT_TRUE(judge.grow().empty());
        judge.finish(measured.setups[1], measured.points(1));
        EXPECT_EQ(judge.grow().size(), fitting::needs_neighbours(method) ? 1U : 0U) << name;
        judge.finish(measured.setups[2], measured.points(2));
        judge.grow();
        EXPECT_EQ(judge.complete().size(), fitting::needs_neighbours(method) ? 3U : 0U) << name;
        for (const auto& section : judge.take()) {
            EXPECT_EQ(section.compensation.state, Method::final) << name << ": " << section.compensation.note;
            EXPECT_EQ(section.compensation.method(), method);
            EXPECT_EQ(section.characteristics.size(), 8U);
            double worst = 0.0;
            for (const auto& deviation : section.deviation_mm)
                worst = std::max(worst, std::abs(deviation.value_or(0.0)));
            EXPECT_LT(worst, 0.025) << name << ": the part is its nominal, without noise";
        }
    }
    const Measured alone(part_text("[20]", "[fitting]\ncompensation = \"mean_vector\"\n"));
    PartJudge judge;
    judge.finish(alone.setups[0], alone.points(0));
    judge.complete();
    const auto only = judge.take();
    EXPECT_EQ(only[0].compensation.state, Method::flat);
    EXPECT_EQ(only[0].compensation.method(), CompensationMethod::flat);
    EXPECT_NE(only[0].compensation.note.find("no other section"), std::string::npos) << only[0].compensation.note;
}

TEST_F(PartJudgeTest, WhatStaysFlatSaysWhy) {
    const Measured asked(part_text("[20, 30, 40]", "[fitting]\ncompensation = \"2d\"\n"));
    PartJudge judge;
    for (std::size_t i = 0; i < 3; ++i)
        judge.finish(asked.setups[i], asked.points(i));
    EXPECT_TRUE(judge.complete().empty());
    for (const auto& section : judge.take()) {
        EXPECT_EQ(section.compensation.state, Method::flat);
        EXPECT_EQ(section.compensation.note, "asked for");
    }

    const Measured alone(part_text("[20]"));
    judge.finish(alone.setups[0], alone.points(0));
    EXPECT_EQ(judge.complete().size(), 1U);
    const auto only = judge.take();
    EXPECT_EQ(only[0].compensation.state, Method::flat);
    EXPECT_NE(only[0].compensation.note.find("no other section"), std::string::npos) << only[0].compensation.note;

    // A section that is not evaluable does not hinder the others.
    const Measured measured(part_text("[20, 30, 40]"));
    for (std::size_t i = 0; i < 3; ++i) {
        auto points = measured.points(i);
        if (i == 1) points.resize(5);
        judge.finish(measured.setups[i], std::move(points));
        judge.grow();
    }
    EXPECT_EQ(judge.complete().size(), 2U);
    const auto sections = judge.take();
    EXPECT_EQ(sections[0].compensation.state, Method::final);
    EXPECT_FALSE(sections[1].has_contour());
    EXPECT_EQ(sections[1].compensation.state, Method::flat);
    EXPECT_EQ(sections[2].compensation.state, Method::final);
}

TEST_F(PartJudgeTest, WallsThatLeanMoreThanTheNominalDoNotRejectBeforeTheirLeanIsKnown) {
    const LeaningPart part(leaning_text("profile_mm = 0.016\n"), leans_more);
    PartJudge judge;
    const auto& first = judge.finish(part.setups[0], part.points(0));
    ASSERT_EQ(first.compensation.state, Method::provisional);
    EXPECT_EQ(first.decision(), Decision::reject) << "the offset trusts the nominal's lean";
    EXPECT_FALSE(judge.rejects_for_certain(0));
    judge.grow();
    for (const std::size_t next : {1U, 2U}) {
        judge.finish(part.setups[next], part.points(next));
        judge.grow();
    }
    const auto sections = judge.results();
    EXPECT_EQ(sections[1].compensation.state, Method::final);
    EXPECT_EQ(sections[1].decision(), Decision::accept) << *sections[1].find("profile_suction")->value;
    EXPECT_FALSE(judge.rejects_for_certain(1));
}

TEST_F(PartJudgeTest, APartThatIsOutWhateverItsLeanIsRejectedAtOnce) {
    const LeaningPart part(leaning_text("profile_mm = 0.016\n"), leans_more, 0.02);
    PartJudge judge;
    judge.finish(part.setups[0], part.points(0));
    EXPECT_TRUE(judge.rejects_for_certain(0));
    // Too thin is thinner still where the wall leans more.
    const LeaningPart thin(leaning_text("profile_mm = 0.016\n"), leans_more, -0.08);
    PartJudge other;
    other.finish(thin.setups[0], thin.points(0));
    EXPECT_TRUE(other.rejects_for_certain(0));
    EXPECT_FALSE(other.rejects_for_certain(1)) << "not measured";
}

TEST_F(PartJudgeTest, WithoutANominalTheLeanHasToBeMeasured) {
    const LeaningPart part(leaning_text("profile_mm = 0.1\n"), leans_more);
    const auto setups = too_thick_without_nominal(part);
    PartJudge judge;
    judge.finish(setups[0], part.points(0));
    EXPECT_EQ(judge.results()[0].decision(), Decision::reject);
    EXPECT_FALSE(judge.rejects_for_certain(0));
    judge.grow();
    judge.finish(setups[1], part.points(1));
    judge.grow();
    EXPECT_EQ(judge.results()[0].compensation.state, Method::final);
    EXPECT_TRUE(judge.rejects_for_certain(0)) << "half a millimetre too thick";
}

/// One section elsewhere, at the height of another: it keeps its own contour.
TEST_F(PartJudgeTest, ASectionThatDoesNotJoinKeepsIts2dContour) {
    const Measured measured(part_text("[20, 30, 40]"));
    PartJudge judge;
    for (std::size_t i = 0; i < 3; ++i) {
        auto points = measured.points(i);
        if (i == 1)
            for (auto& point : points)
                point.centre_mm.x() += 300.0;
        judge.finish(measured.setups[i], std::move(points));
        const auto revised = judge.grow();
        if (i == 1) {
            ASSERT_EQ(revised.size(), 1U);
            EXPECT_EQ(revised[0]->index, 1U);
            EXPECT_EQ(revised[0]->compensation.state, Method::flat);
            EXPECT_EQ(judge.foretell(), nullptr);
        }
    }
    judge.complete();
    const auto sections = judge.take();
    EXPECT_EQ(sections[1].compensation.state, Method::flat);
    EXPECT_NE(sections[1].compensation.note.find("does not continue"), std::string::npos);
    EXPECT_EQ(sections[2].compensation.state, Method::final);
}

}  // namespace
}  // namespace cmm::acquisition
