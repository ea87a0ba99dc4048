// SPDX-License-Identifier: Apache-2.0
#include "acquisition/alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <nlohmann/json.hpp>

#include "acquisition/evaluation.hpp"
#include "acquisition/exports.hpp"
#include "acquisition/live_section.hpp"
#include "acquisition/part_judge.hpp"
#include "acquisition/run_results.hpp"
#include "core/units.hpp"
#include "fitting/datum.hpp"
#include "tests/acquisition/session_fixture.hpp"
#include "tests/acquisition/synthetic_blade.hpp"

namespace cmm::acquisition {
namespace {

using fitting::PlaneMotion;
using AlignmentState = Alignment::State;

std::string aligned_text(const std::string& alignment, const std::string& characteristics = "") {
    return session_part_text() + "[alignment]\n" + alignment + characteristics;
}

std::string refusal(const std::string& text) {
    const auto part = parse_part_file(text, "p.toml");
    return part ? "" : part.error().message;
}

TEST(Alignment, IsReadFromThePartFile) {
    EXPECT_EQ(parse_part_file(session_part_text(), "p.toml")->alignment.kind, AlignmentKind::none);
    const auto part = parse_part_file(aligned_text("kind = \"blade\"\nobjective = \"min_max\"\ntranslation = \"y\"\n"
                                                   "rotation = \"fixed\"\nzones = [\"suction\", \"pressure\"]\n"),
                                      "p.toml");
    ASSERT_TRUE(part) << part.error().text();
    const auto& spec = part->alignment;
    EXPECT_EQ(spec.kind, AlignmentKind::blade);
    EXPECT_EQ(spec.objective, fitting::FitObjective::min_max);
    EXPECT_FALSE(spec.translate_x);
    EXPECT_TRUE(spec.translate_y);
    EXPECT_FALSE(spec.rotate);
    EXPECT_EQ(spec.zones, (std::array<bool, 4>{false, true, false, true}));
    EXPECT_EQ(frame_words(spec),
              "after the best fit of the blade (smallest largest deviation; free: y; of suction pressure)");
}

TEST(Alignment, RefusesWhatContradictsItself) {
    const std::string bare =
        "[part]\nname = \"u\"\n[nominal]\nkind = \"none\"\n[scan]\nheights_mm = [1]\nbox_mm = [-1, -1, 1, 1]\n";
    EXPECT_TRUE(holds(refusal(bare + "[alignment]\nkind = \"section\"\n"), "needs a nominal"));
    std::string ungated = aligned_text("kind = \"section\"\nobjective = \"into_tolerance\"\n");
    ungated.replace(ungated.find("edge_profile_mm = 0.1"), 21, "");
    EXPECT_TRUE(holds(refusal(ungated), "gate.edge_profile_mm"));
    EXPECT_EQ(refusal(ungated + "zones = [\"suction\"]\n"), "");
    EXPECT_TRUE(holds(refusal(aligned_text("kind = \"section\"\ntranslation = \"none\"\nrotation = \"fixed\"\n")),
                      "nothing may move"));
    EXPECT_TRUE(holds(refusal(aligned_text("objective = \"min_max\"\n")), "needs kind"));
    EXPECT_TRUE(holds(refusal(aligned_text("kind = \"blade\"\nzones = [\"nose\"]\n")), "none of le, suction"));
    EXPECT_TRUE(holds(refusal(aligned_text("kind = \"whole\"\n")), "kind"));
}

/// A contour of the synthetic blade after `motion`, with `bump` of material more.
template <class Bump>
fitting::SectionFit put(const PlaneMotion& motion, const Bump& bump) {
    PlaneMotion back;
    back.about_mm = motion.about_mm + motion.shift_mm;
    back.shift_mm = -motion.shift_mm;
    back.turn_rad = -motion.turn_rad;
    const synthetic::Shape shape;
    auto fit = synthetic::fit_of(synthetic::Section(shape), shape, bump);
    fit.le_scale_mm = shape.le_radius_mm;
    fit.te_scale_mm = shape.te_radius_mm;
    return fitting::undone(std::move(fit), back);
}

PlaneMotion some_motion() {
    PlaneMotion motion;
    motion.about_mm = {2.0, -1.0};
    motion.shift_mm = {0.08, -0.05};
    motion.turn_rad = 0.003;
    return motion;
}

struct Judging {
    synthetic::Section section{synthetic::Shape{}};
    fitting::NominalSection curve = fitting::analyse_nominal(synthetic::positions(section.contour())).value();
    ReferenceContour reference = synthetic::reference(section, 0.0);
    EvaluationOptions options;

    explicit Judging(AlignmentKind kind) {
        options.profile_mm = 0.10;
        options.edge_profile_mm = 0.06;
        options.alignment.kind = kind;
    }
    SectionResult operator()(fitting::SectionFit fit, const SectionAlignment* shared = nullptr) const {
        SectionResult raw;
        raw.z_mm = 40.0;
        raw.points = synthetic::points_of(fit, 1.0, 40.0, 1, 50, 5);
        return evaluate_section(std::move(raw), std::move(fit), &reference, options, &curve, shared);
    }
};

double no_bump(const fitting::ContourPoint&) {
    return 0.0;
}
/// Three micrometres: a min-max fit rests on the crests.
double waves(const fitting::ContourPoint& point) {
    return 0.003 * std::sin(1.3 * point.arc_length_mm);
}

TEST(Alignment, ASectionIsJudgedWhereItsBestFitLaysIt) {
    const auto motion = some_motion();
    EXPECT_EQ(Judging(AlignmentKind::none)(put(motion, waves)).decision(), Decision::reject);
    double of_squares = 0.0;
    for (const auto objective : {fitting::FitObjective::least_squares, fitting::FitObjective::min_max,
                                 fitting::FitObjective::into_tolerance}) {
        Judging judging(AlignmentKind::section);
        judging.options.alignment.objective = objective;
        const auto result = judging(put(motion, waves));
        if (objective == fitting::FitObjective::least_squares) of_squares = result.alignment.largest_mm;
        if (objective == fitting::FitObjective::min_max) {
            EXPECT_LT(result.alignment.largest_mm, of_squares);
        }
        EXPECT_EQ(result.alignment.state, AlignmentState::final);
        EXPECT_EQ(result.decision(), Decision::accept);
        EXPECT_NEAR(result.alignment.motion.turn_rad, motion.turn_rad, 2e-4);
        EXPECT_LT((result.alignment.motion.apply({5, 5}) - motion.apply({5, 5})).norm(), 3e-3);
        for (std::size_t i = 0; i < result.deviation_mm.size(); ++i) {
            const double d = result.deviation_mm[i].value();
            ASSERT_LE(std::abs(d), result.alignment.largest_mm + 1e-4);
        }
        const auto* profile = result.find("profile_suction");
        EXPECT_TRUE(holds(profile->method, "after the best fit of the section")) << profile->method;
        EXPECT_GT(result.alignment.covariance(0, 0), 0.0);
        EXPECT_GT(result.alignment.condition, 1.0);
        // The contour is kept as measured; the nominal of the pictures lies on it.
        const auto& contour = result.fit->contour;
        double nearest = 1e9;
        for (const auto& p : result.nominal_contour)
            nearest = std::min(nearest, (p - contour[100].position_mm).norm());
        EXPECT_LT(nearest, 0.05);
        EXPECT_GT((contour[100].position_mm - Judging(AlignmentKind::none).section.contour()[100].position_mm).norm(),
                  0.03);
        // U95 of a deviation holds that of the motion.
        EXPECT_GT(result.deviation_u95_mm(100), contour[100].u95_mm);
    }
}

TEST(Alignment, WhatIsHeldCounts) {
    auto motion = some_motion();
    motion.turn_rad = 0.0;
    Judging judging(AlignmentKind::section);
    judging.options.alignment.translate_y = false;
    const auto result = judging(put(motion, no_bump));
    EXPECT_EQ(result.alignment.motion.shift_mm.y(), 0.0);
    EXPECT_EQ(result.alignment.covariance(1, 1), 0.0);
    EXPECT_NE(result.decision(), Decision::accept);
    judging.options.alignment.translate_y = true;
    judging.options.alignment.rotate = false;
    EXPECT_EQ(judging(put(motion, no_bump)).decision(), Decision::accept);
}

TEST(Alignment, IsRefusedWhereContourAndNominalDoNotLieOnEachOther) {
    Judging judging(AlignmentKind::section);
    auto motion = some_motion();
    motion.turn_rad = 3.1415;
    judging.options.alignment.zones = {true, false, false, false};
    const auto result = judging(put(motion, no_bump));
    if (result.alignment.state == AlignmentState::refused) {
        EXPECT_TRUE(result.deviation_mm.empty());
        EXPECT_EQ(result.find("profile_le")->decision, Decision::not_evaluable);
        EXPECT_FALSE(result.find("profile_le")->note.empty());
        EXPECT_EQ(result.decision(), Decision::undecided);
    } else {
        ADD_FAILURE() << "a section that stands on its head: " << alignment_words(result.alignment);
    }
}

TEST(Alignment, ABladeThatIsNotCompleteIsJudgedOnlyWhereNoMotionHelps) {
    const Judging judging(AlignmentKind::blade);
    const auto good = judging(put(some_motion(), no_bump));
    EXPECT_EQ(good.alignment.state, AlignmentState::provisional);
    EXPECT_EQ(good.decision(), Decision::undecided);
    EXPECT_EQ(good.find("profile_suction")->decision, Decision::undecided);
    EXPECT_TRUE(holds(good.find("profile_suction")->note, "provisional"));
    // 60 um too thick on both sides: no motion brings it into +-50 um.
    const auto fat = judging(put(some_motion(), [](const auto& p) {
        return p.zone == fitting::Zone::suction || p.zone == fitting::Zone::pressure ? 0.06 : 0.0;
    }));
    EXPECT_EQ(fat.decision(), Decision::reject);
    // 70 um too thick on one side and too thin on the other is a shift.
    const auto shifted = judging(put({}, [](const auto& p) { return 0.07 * p.normal.y(); }));
    EXPECT_EQ(shifted.decision(), Decision::undecided);
}

TEST(Alignment, PositionsAreThoseInTheFrameOfTheBlade) {
    Judging judging(AlignmentKind::blade);
    const auto specs =
        parse_part_file(session_part_text() +
                            "[[characteristic]]\nname = \"displacement_x\"\ntolerance_mm = 0.02\n"
                            "[[characteristic]]\nname = \"twist\"\n[[characteristic]]\nname = \"chord\"\n",
                        "p.toml");
    ASSERT_TRUE(specs) << specs.error().text();
    judging.options.asked = specs->gate.characteristics;
    const auto motion = some_motion();
    const auto fit = put(motion, no_bump);
    SectionAlignment shared;
    shared.alignment.state = AlignmentState::final;
    shared.alignment.spec = judging.options.alignment;
    shared.alignment.motion = shared.datum.motion = motion;
    shared.datum.covariance = shared.datum.from_others =
        Eigen::Vector3d(std::pow(0.002, 2), std::pow(0.003, 2), std::pow(1e-4, 2)).asDiagonal();
    shared.alignment.covariance = shared.datum.covariance;
    const auto aligned = judging(fit, &shared);
    EXPECT_EQ(aligned.decision(), Decision::accept);
    const auto* x = aligned.find("displacement_x");
    EXPECT_NEAR(*x->value, 0.0, 1e-4);
    EXPECT_NEAR(*aligned.find("twist")->value, 0.0, 1e-6);
    EXPECT_TRUE(holds(x->note, "aligned blade"));
    // What is not known of the motion is in the position, and not in the chord.
    const auto as_measured = Judging(AlignmentKind::none);
    auto none = as_measured;
    none.options.asked = judging.options.asked;
    const auto plain = none(fit);
    EXPECT_NEAR(*x->u95, std::hypot(*plain.find("displacement_x")->u95, 2.0 * 0.002), 0.1 * *x->u95);
    EXPECT_NEAR(*aligned.find("twist")->u95, std::hypot(*plain.find("twist")->u95, 2e-4), 1e-5);
    EXPECT_NEAR(*aligned.find("chord")->u95, *plain.find("chord")->u95, 1e-6);
    EXPECT_NEAR(*aligned.find("chord")->value, *plain.find("chord")->value, 1e-6);
}

/// The paths of a plan as points of a part that was put elsewhere.
struct Placed {
    SessionPart job;
    PlaneMotion motion = some_motion();
    std::deque<SectionSetup> setups;
    explicit Placed(const std::string& text) : job(text) {
        for (std::size_t i = 0; i < job.plan.paths.size(); ++i)
            setups.push_back(job.setup(i));
    }
    std::vector<RecordedPoint> points(std::size_t index, double thicker_mm = 0.0) const {
        std::vector<RecordedPoint> points;
        for (const auto& planned : job.plan.paths[index].points) {
            RecordedPoint point;
            point.sequence = points.size() + 1;
            const Eigen::Vector3d centre = planned.centre_mm + thicker_mm * planned.normal;
            point.centre_mm << motion.apply(centre.head<2>()), centre.z();
            points.push_back(point);
        }
        return points;
    }
};

PlaneMotion blade_alignment(const std::string& text, const PlaneMotion& motion) {
    Placed placed(text);
    placed.motion = motion;
    PartJudge judge;
    judge.finish(placed.setups[0], placed.points(0));
    judge.finish(placed.setups[1], placed.points(1));
    judge.complete();
    return judge.take()[0].alignment.motion;
}

TEST(Alignment, FollowsTheBladeWhereverItIsPut) {
    for (const char* objective : {"least_squares", "min_max", "into_tolerance"}) {
        const auto text = aligned_text("kind = \"blade\"\nobjective = \"" + std::string(objective) + "\"\n");
        const auto before = blade_alignment(text, {}), after = blade_alignment(text, some_motion());
        const bool squares = text.find("squares") != std::string::npos;
        for (const Eigen::Vector2d& p : {Eigen::Vector2d(0, 0), Eigen::Vector2d(20, 10)})
            EXPECT_LT((after.apply(p) - some_motion().apply(before.apply(p))).norm(), squares ? 1e-4 : 5e-4)
                << objective;
    }
}

TEST(Alignment, TheWholeBladeIsLaidOntoItsNominalWhenItIsComplete) {
    const Placed placed(
        aligned_text("kind = \"blade\"\n", "[[characteristic]]\nname = \"twist\"\ntolerance_deg = 0.05\n"));
    PartJudge judge;
    for (const std::size_t i : {0U, 1U}) {
        const auto& alone = judge.finish(placed.setups[i], placed.points(i));
        EXPECT_EQ(alone.alignment.state, AlignmentState::provisional);
        EXPECT_EQ(alone.decision(), Decision::undecided);
        judge.grow();
    }
    EXPECT_FALSE(judge.completing());
    judge.begin_completion(true);
    EXPECT_TRUE(judge.completing());
    std::size_t steps = 0;
    while (judge.complete_next() != nullptr)
        ++steps;
    EXPECT_EQ(steps, 4U) << "each is compensated, and each is aligned";
    EXPECT_FALSE(judge.completing());
    const auto sections = judge.take();
    for (const auto& section : sections) {
        EXPECT_EQ(section.alignment.state, AlignmentState::final);
        EXPECT_EQ(section.decision(), Decision::accept) << alignment_words(section.alignment);
        EXPECT_EQ(section.alignment.sections, 2U);
        // The plan's centres leave what the lean does to a contour in its plane.
        EXPECT_NEAR(section.alignment.motion.turn_rad, placed.motion.turn_rad, 2e-4);
        EXPECT_LT((section.alignment.motion.apply({0, 0}) - placed.motion.apply({0, 0})).norm(), 1e-2);
        EXPECT_NEAR(*section.find("twist")->value, 0.0, 2e-4);
    }
    EXPECT_EQ(sections[0].alignment.motion.turn_rad, sections[1].alignment.motion.turn_rad);
}

TEST(Alignment, OfABladeThatWasBrokenOffStaysProvisional) {
    const Placed placed(aligned_text("kind = \"blade\"\n"));
    PartJudge judge;
    judge.finish(placed.setups[0], placed.points(0));
    judge.complete(false);
    const auto sections = judge.take();
    EXPECT_EQ(sections[0].alignment.state, AlignmentState::provisional);
    EXPECT_EQ(sections[0].decision(), Decision::undecided);
    PartJudge fat;
    fat.finish(placed.setups[0], placed.points(0, 0.08));
    fat.complete(false);
    EXPECT_EQ(fat.take()[0].decision(), Decision::reject) << "no motion makes it thinner";
}

TEST(Alignment, NothingIsCalledOutBeforeTheSectionCanBeAligned) {
    const auto out = [](const std::string& text) {
        const Placed placed(text);
        LiveSection live(placed.setups[0], 1.0, core::PartFromMachine(), placed.points(0).size());
        live.restore(placed.points(0, 0.3));
        return live.exceedance().has_value();
    };
    EXPECT_TRUE(out(session_part_text()));
    EXPECT_FALSE(out(aligned_text("kind = \"section\"\n")));
    EXPECT_FALSE(out(aligned_text("kind = \"blade\"\n")));
}

TEST(Alignment, StandsInEveryFile) {
    const Placed placed(aligned_text("kind = \"blade\"\n"));
    PartJudge judge;
    judge.finish(placed.setups[0], placed.points(0));
    judge.finish(placed.setups[1], placed.points(1));
    judge.complete();
    PartResult part;
    part.part_name = "blade";
    part.has_nominal = true;
    part.sections = judge.take();
    const auto json = nlohmann::json::parse(result_json(part));
    const auto& alignment = json["sections"][1]["alignment"];
    EXPECT_EQ(alignment["state"], "final");
    EXPECT_EQ(alignment["kind"], "blade");
    EXPECT_EQ(alignment["objective"], "least_squares");
    EXPECT_EQ(alignment["free"], "x y rotation");
    EXPECT_NEAR(alignment["turn_rad"].get<double>(), placed.motion.turn_rad, 2e-4);
    EXPECT_GT(alignment["shift_x_standard_mm"].get<double>(), 0.0);
    EXPECT_GT(alignment["rounds"].get<int>(), 1);
    EXPECT_EQ(alignment["sections"], 2);
    const auto csv = sections_csv(part);
    EXPECT_TRUE(holds(csv, ",alignment,shift_x_mm,shift_x_standard_mm"));
    EXPECT_TRUE(holds(csv, ",final,"));
    const auto rows = std::count(csv.begin(), csv.end(), '\n');
    EXPECT_EQ(std::count(csv.begin(), csv.end(), ',') % rows, 0) << "every row has every column";
    const auto report = report_html(part);
    EXPECT_TRUE(holds(report, "after the best fit of the blade"));
    EXPECT_TRUE(holds(report, "rotation +0."));
}

}  // namespace
}  // namespace cmm::acquisition
