// SPDX-License-Identifier: Apache-2.0
#include "acquisition/part_characteristics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <nlohmann/json.hpp>

#include "acquisition/evaluation.hpp"
#include "acquisition/exports.hpp"
#include "acquisition/part_judge.hpp"
#include "core/rng.hpp"
#include "core/units.hpp"
#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {
namespace {

std::vector<CharacteristicSpec> specs_of(const std::string& characteristics) {
    const auto part = parse_part_file(session_part_text() + characteristics, "p.toml");
    EXPECT_TRUE(part) << part.error().text();
    return part ? part->gate.characteristics : std::vector<CharacteristicSpec>{};
}

std::string complaint(const std::string& characteristics) {
    const auto part = parse_part_file(session_part_text() + characteristics, "p.toml");
    return part ? "" : part.error().message;
}

SectionResult section_at(std::size_t index, double z_mm, const Eigen::Vector2d& shift, double turn_rad) {
    SectionResult section;
    section.index = index;
    section.z_mm = z_mm;
    SectionPlacement placement;
    placement.shift_mm = shift;
    placement.turn_rad = turn_rad;
    placement.covariance = Eigen::Vector3d(1e-6, 4e-6, 1e-8).asDiagonal();
    section.placements = {placement};
    return section;
}

/// Displacements by hand: root (0.01, 0.02), tip (0.05, -0.02), between them what the test says.
PartResult blade(const Eigen::Vector2d& middle) {
    PartResult part;
    part.sections = {section_at(0, 10.0, {0.01, 0.02}, 0.001), section_at(1, 20.0, middle, 0.004),
                     section_at(2, 50.0, {0.05, -0.02}, 0.002)};
    return part;
}

const Characteristic* find_in(const PartResult& part, const std::string& name,
                              std::optional<std::size_t> section = {}) {
    for (const auto& c : part.characteristics)
        if (c.number.name == name && c.section == section) return &c.number;
    return nullptr;
}

TEST(PartCharacteristics, LeanIsWhatTheTipIsFromTheRoot) {
    auto part = blade({0.0, 0.0});
    add_part_characteristics(specs_of("[[characteristic]]\nname = \"lean_x\"\ntolerance_mm = 0.03\n"
                                      "[[characteristic]]\nname = \"lean_y\"\nlower_mm = -0.05\nupper_mm = 0.01\n"),
                             {}, part);
    ASSERT_EQ(part.characteristics.size(), 2U);
    const auto *x = find_in(part, "lean_x"), *y = find_in(part, "lean_y");
    EXPECT_NEAR(*x->value, 0.04, 1e-12);
    EXPECT_NEAR(*x->u95, 2.0 * std::sqrt(2e-6), 1e-12);
    EXPECT_EQ(x->decision, Decision::reject);
    EXPECT_NEAR(*y->value, -0.04, 1e-12);
    EXPECT_EQ(y->decision, Decision::accept);
    EXPECT_EQ(part.verdict(), Decision::reject);
    const auto reasons = verdict_reasons(part);
    ASSERT_FALSE(reasons.empty());
    EXPECT_TRUE(holds(reasons.front(), "part: lean_x 0.040 mm")) << reasons.front();
}

/// A requirement that nobody can judge is not met by silence.
TEST(PartCharacteristics, WhatCannotBeJudgedIsSaid) {
    auto part = blade({0.0, 0.0});
    const auto absent = specs_of("[[characteristic]]\nname = \"area\"\nsections = [1, 3, 7]\ntolerance_mm2 = 1\n");
    add_part_characteristics(absent, {}, part);
    ASSERT_EQ(part.characteristics.size(), 1U);
    EXPECT_EQ(part.characteristics[0].number.decision, Decision::not_evaluable);
    EXPECT_EQ(part.characteristics[0].number.note, "section 3, 7: there is no such section; they count from 0");
    EXPECT_EQ(part.verdict(), Decision::undecided);

    const auto asked = specs_of(
        "[[characteristic]]\nname = \"lean_x\"\ntolerance_mm = 1\n"
        "[[characteristic]]\nname = \"bow_x\"\ntolerance_mm = 1\n"
        "[[characteristic]]\nname = \"relative_twist\"\ntolerance_deg = 1\n");
    part.sections.resize(2);
    add_part_characteristics(asked, {}, part);
    EXPECT_EQ(find_in(part, "lean_x")->decision, Decision::accept);
    ASSERT_NE(find_in(part, "bow_x"), nullptr);
    EXPECT_EQ(find_in(part, "bow_x")->decision, Decision::not_evaluable);
    EXPECT_NE(find_in(part, "relative_twist", 1), nullptr);
    part.sections.resize(1);
    add_part_characteristics(asked, {}, part);
    for (const char* name : {"lean_x", "bow_x", "relative_twist"}) {
        ASSERT_NE(find_in(part, name), nullptr) << name;
        EXPECT_EQ(find_in(part, name)->decision, Decision::not_evaluable) << name;
        EXPECT_FALSE(find_in(part, name)->value) << name;
    }
    EXPECT_EQ(part.verdict(), Decision::undecided);

    // While a part is not complete nobody asks for what is still to come.
    part.complete = false;
    add_part_characteristics(absent, {}, part);
    EXPECT_TRUE(part.characteristics.empty());
}

TEST(PartCharacteristics, ALabelIsNotTheNameOfAnother) {
    const auto labelled = [](const char* label) {
        return complaint("[[characteristic]]\nname = \"stagger\"\nlabel = \"" + std::string(label) + "\"\n");
    };
    EXPECT_TRUE(holds(labelled("chord"), "is the name of another characteristic")) << labelled("chord");
    EXPECT_TRUE(holds(labelled("profile_le"), "is the name of another characteristic"));
    EXPECT_EQ(labelled("stagger"), "");
    EXPECT_EQ(labelled("angle of the blade"), "");
}

/// What all sections have in common cancels where it is the same in both, and adds up where it is not.
TEST(PartCharacteristics, WhatSectionsShareIsCountedWithItsSign) {
    const auto asked =
        specs_of("[[characteristic]]\nname = \"lean_x\"\n[[characteristic]]\nname = \"relative_twist\"\n");
    const auto u95 = [&](double at_root, double at_tip) {
        auto part = blade({0.0, 0.0});
        part.uncertainty.machine.length_mm = 1e-3;
        part.sections.front().placements.front().loads(0, 3) = at_root;
        part.sections.back().placements.front().loads(0, 3) = at_tip;
        add_part_characteristics(asked, {}, part);
        return *find_in(part, "lean_x")->u95;
    };
    const double noise = 2.0 * std::sqrt(2e-6);
    EXPECT_NEAR(u95(0.004, 0.004), noise, 1e-12);
    EXPECT_NEAR(u95(0.004, -0.004), std::hypot(noise, 2.0 * 0.008), 1e-12);
    auto part = blade({0.0, 0.0});
    part.uncertainty.machine.length_mm = 1e-3;
    part.sections.back().placements.front().places(0, 0) = 0.75e-6;
    part.sections.back().placements.front().loads(0, 21) = -0.005;
    add_part_characteristics(asked, {}, part);
    const auto& lean = *find_in(part, "lean_x");
    EXPECT_NEAR(*lean.u95, noise + 0.005, 1e-12) << "what is known is added";
    EXPECT_NEAR(lean.budget->noise, std::sqrt(1.25e-6), 1e-12);
    EXPECT_NEAR(lean.budget->of(fitting::ErrorSource::length), std::sqrt(0.75e-6), 1e-12);
    EXPECT_NEAR(lean.budget->bound, 0.005, 1e-12);
}

TEST(PartCharacteristics, BowIsWhatASectionIsFromTheLineBetweenTheEnds) {
    // A quarter of the way from root to tip the line passes (0.02, 0.01).
    auto part = blade({0.02 + 0.03, 0.01 - 0.04});
    add_part_characteristics(specs_of("[[characteristic]]\nname = \"bow_x\"\n[[characteristic]]\nname = \"bow_y\"\n"
                                      "[[characteristic]]\nname = \"BOWT\"\ntolerance_mm = 0.2\n"),
                             {}, part);
    ASSERT_EQ(part.characteristics.size(), 3U) << "of the section between the ends alone";
    EXPECT_NEAR(*find_in(part, "bow_x", 1)->value, 0.03, 1e-12);
    EXPECT_NEAR(*find_in(part, "bow_y", 1)->value, -0.04, 1e-12);
    EXPECT_NEAR(*find_in(part, "bow_x", 1)->u95, 2.0 * std::sqrt(1e-6 * (1.0 + 0.75 * 0.75 + 0.25 * 0.25)), 1e-12);
    const auto* both = find_in(part, "bow_true_position", 1);
    EXPECT_NEAR(*both->value, 0.1, 1e-12);
    EXPECT_NEAR(*both->u95, 2.0 * 2.0 * std::sqrt((0.36 * 1e-6 + 0.64 * 4e-6) * 1.625), 1e-9);
    EXPECT_EQ(both->decision, Decision::accept);
    EXPECT_FALSE(both->lower);
    // Where the bow is less than its noise any direction may be that of the error.
    auto straight = blade({0.02, 0.01});
    add_part_characteristics(specs_of("[[characteristic]]\nname = \"BOWT\"\n"), {}, straight);
    EXPECT_NEAR(*straight.characteristics.at(0).number.u95, 2.0 * 2.0 * std::sqrt(4e-6 * 1.625), 1e-9);
}

TEST(PartCharacteristics, EndsAndReferencesAreChosen) {
    auto part = blade({0.0, 0.0});
    add_part_characteristics(specs_of("[[characteristic]]\nname = \"lean_x\"\nroot_section = 1\n"
                                      "[[characteristic]]\nname = \"relative_twist\"\nreference_section = 1\n"
                                      "[[characteristic]]\nname = \"relative_twist\"\nlabel = \"to root\"\n"),
                             {}, part);
    EXPECT_NEAR(*find_in(part, "lean_x")->value, 0.05, 1e-12);
    EXPECT_NEAR(*find_in(part, "relative_twist", 0)->value, -0.003, 1e-12);
    EXPECT_NEAR(*find_in(part, "relative_twist", 2)->value, -0.002, 1e-12);
    EXPECT_EQ(find_in(part, "relative_twist", 1), nullptr);
    EXPECT_NEAR(*find_in(part, "to root", 1)->value, 0.003, 1e-12);
    EXPECT_NEAR(*find_in(part, "to root", 1)->u95, 2.0 * std::sqrt(2e-8), 1e-12);
}

TEST(PartCharacteristics, ALeanAnswersToTheTiltOfThePartsFrame) {
    const auto specs = specs_of("[[characteristic]]\nname = \"lean_x\"\n[[characteristic]]\nname = \"lean_y\"\n");
    auto part = blade({0.0, 0.0});
    const double rise = part.sections.back().z_mm - part.sections.front().z_mm;
    add_part_characteristics(specs, {}, part);
    const double own_x = *find_in(part, "lean_x")->u95, own_y = *find_in(part, "lean_y")->u95;
    part.part_frame.emplace();
    part.part_frame->covariance(4, 4) = 9e-8;
    part.part_frame->covariance(3, 3) = 4e-8;
    add_part_characteristics(specs, {}, part);
    EXPECT_NEAR(*find_in(part, "lean_x")->u95, std::hypot(own_x, 2.0 * 3e-4 * rise), 1e-12);
    EXPECT_NEAR(*find_in(part, "lean_y")->u95, std::hypot(own_y, 2.0 * 2e-4 * rise), 1e-12);
}

TEST(PartCharacteristics, TheGeneratrixIsABandAboutItsLine) {
    const auto specs = specs_of("[[characteristic]]\nname = \"generatrix\"\nshare = 0.5\ntolerance_mm = 0.05\n");
    EXPECT_EQ(specs.at(0).label, "generatrix_suction_0.5");
    PartResult part;
    // A line in z with +-0.01 about it: the least-squares line of this pattern is the line itself.
    const std::array wave{0.01, -0.01, -0.01, 0.01};
    for (std::size_t i = 0; i < 4; ++i) {
        auto section = section_at(i, 10.0 * static_cast<double>(i), {0, 0}, 0.0);
        section.span_points.push_back({specs.at(0).label, 0.1 + 0.02 * static_cast<double>(i) + wave[i], 1e-3});
        part.sections.push_back(section);
    }
    add_part_characteristics(specs, {}, part);
    const auto* band = find_in(part, "generatrix_suction_0.5");
    EXPECT_NEAR(*band->value, 0.02, 1e-12);
    EXPECT_GT(*band->u95, 2e-3);
    EXPECT_LT(*band->u95, 2.0 * std::sqrt(2.0) * 1e-3 + 1e-9);
    EXPECT_EQ(band->decision, Decision::accept);
    part.sections[2].span_points.clear();
    add_part_characteristics(specs, {}, part);
    EXPECT_EQ(find_in(part, "generatrix_suction_0.5")->decision, Decision::not_evaluable);
}

TEST(PartCharacteristics, FollowTheBestFitOfTheirZones) {
    auto part = blade({0.0, 0.0});
    for (auto& section : part.sections) {
        auto sides = section.placements[0];
        sides.zones = {false, true, false, true};
        sides.turn_rad += 0.01 * static_cast<double>(section.index);
        section.placements.push_back(sides);
    }
    const auto specs = specs_of(
        "[[characteristic]]\nname = \"RELTWIST\"\n[[characteristic]]\nname = \"relative_twist\"\nlabel = \"of_sides\"\n"
        "fit_zones = [\"suction\", \"pressure\"]\n");
    add_part_characteristics(specs, {}, part);
    EXPECT_NEAR(*find_in(part, "relative_twist", 1)->value, 0.003, 1e-12);
    EXPECT_NEAR(*find_in(part, "of_sides", 1)->value, 0.013, 1e-12);
    EXPECT_TRUE(holds(find_in(part, "of_sides", 1)->method, "best fit of suction pressure"));
    part.sections[1].placements.pop_back();
    add_part_characteristics(specs, {}, part);
    EXPECT_EQ(find_in(part, "of_sides", 1)->decision, Decision::not_evaluable);
    EXPECT_NEAR(*find_in(part, "relative_twist", 1)->value, 0.003, 1e-12);
    EXPECT_TRUE(holds(complaint("[[characteristic]]\nname = \"lean_x\"\nfit_zones = [\"nose\"]\n"), "none of le"));
    EXPECT_TRUE(holds(complaint("[[characteristic]]\nname = \"chord\"\nfit_zones = [\"le\"]\n"), "unknown key"));
}

TEST(PartCharacteristics, SayWhyTheyCannotBeEvaluated) {
    const auto specs = specs_of("[[characteristic]]\nname = \"lean_x\"\ntolerance_mm = 0.1\n");
    auto part = blade({0.0, 0.0});
    part.sections[2].placements.clear();
    part.sections[2].why = "gap of 3 mm";
    add_part_characteristics(specs, {}, part);
    const auto* lean = find_in(part, "lean_x");
    EXPECT_EQ(lean->decision, Decision::not_evaluable);
    EXPECT_TRUE(holds(lean->note, "mm): gap of 3 mm")) << lean->note;
    EXPECT_EQ(part.verdict(), Decision::undecided);
    auto broken = blade({0.0, 0.0});
    broken.complete = false;
    add_part_characteristics(specs, {}, broken);
    EXPECT_TRUE(holds(find_in(broken, "lean_x")->note, "not all sections"));
    EXPECT_TRUE(holds(complaint("[[characteristic]]\nname = \"generatrix\"\n"), "share"));
    EXPECT_TRUE(
        holds(complaint("[[characteristic]]\nname = \"lean_x\"\nroot_section = 1\ntip_section = 1\n"), "differ"));
    EXPECT_TRUE(holds(complaint("[[characteristic]]\nname = \"BOWT\"\nnominal_mm = 1\n"), "full width"));
}

/// The interval of a bow whose displacements carry the noise that their covariance says holds the truth.
TEST(PartCharacteristics, IntervalsHoldTheTruth) {
    core::Rng rng(71);
    const auto specs = specs_of(
        "[[characteristic]]\nname = \"bow_true_position\"\n[[characteristic]]\nname = \"lean_x\"\n"
        "[[characteristic]]\nname = \"relative_twist\"\nsections = [2]\n"
        "[[characteristic]]\nname = \"generatrix\"\nshare = 0.5\n");
    const Eigen::Vector2d middle(0.05, -0.03);
    const std::array form{0.02, -0.03, 0.01};
    auto exact = blade(middle);
    for (std::size_t i = 0; i < 3; ++i)
        exact.sections[i].span_points = {{"generatrix_suction_0.5", form[i], 1e-3}};
    add_part_characteristics(specs, {}, exact);
    constexpr int trials = 4000;
    std::vector<int> held(exact.characteristics.size(), 0);
    for (int k = 0; k < trials; ++k) {
        auto noisy = exact;
        for (auto& section : noisy.sections) {
            section.placements[0].shift_mm += Eigen::Vector2d(1e-3 * rng.normal(), 2e-3 * rng.normal());
            section.placements[0].turn_rad += 1e-4 * rng.normal();
            section.span_points[0].deviation_mm += 1e-3 * rng.normal();
        }
        add_part_characteristics(specs, {}, noisy);
        for (std::size_t i = 0; i < held.size(); ++i) {
            const auto &said = noisy.characteristics[i].number, &is = exact.characteristics[i].number;
            held[i] += std::abs(*said.value - *is.value) <= *said.u95;
        }
    }
    for (std::size_t i = 0; i < held.size(); ++i) {
        EXPECT_GT(held[i], 0.93 * trials) << name_of(exact.characteristics[i]);
        EXPECT_LT(held[i], 0.97 * trials) << name_of(exact.characteristics[i]);
    }
}

TEST(PartCharacteristics, OfABladeThatLeansAndTwists) {
    std::string text = session_part_text() +
                       "[fitting]\ncompensation = \"2d\"\n"  // in 3-D a contour follows the lean of all sections
                       "[[characteristic]]\nname = \"lean_x\"\n[[characteristic]]\nname = \"lean_y\"\n"
                       "[[characteristic]]\nname = \"relative_twist\"\n"
                       "[[characteristic]]\nname = \"generatrix\"\nside = \"pressure\"\nshare = 0.4\n"
                       "[[characteristic]]\nname = \"bow_true_position\"\n";
    text.replace(text.find("[20, 40]"), 8, "[20, 30, 40]");
    const SessionPart job(text);
    std::deque<SectionSetup> setups;
    const auto measure = [&](bool leaning) {
        PartJudge judge;
        for (std::size_t i = 0; i < 3; ++i) {
            fitting::PlaneMotion motion;
            if (leaning) {
                motion.shift_mm = 0.02 * static_cast<double>(i) * Eigen::Vector2d(1.0, -0.5);
                if (i == 1) motion.shift_mm += Eigen::Vector2d(0.03, 0.0);
            }
            std::vector<RecordedPoint> points;
            for (const auto& planned : job.plan.paths[i].points) {
                RecordedPoint point;
                point.sequence = points.size() + 1;
                point.centre_mm << motion.apply(planned.centre_mm.head<2>()), planned.centre_mm.z();
                points.push_back(point);
            }
            judge.finish(setups.emplace_back(job.setup(i)), std::move(points));
        }
        judge.complete();
        PartResult part;
        part.has_nominal = true;
        part.sections = judge.take();
        add_part_characteristics(job.part.gate.characteristics, job.part.gate.rule, part);
        return part;
    };
    const auto plain = measure(false), leaning = measure(true);
    ASSERT_EQ(leaning.characteristics.size(), 6U);
    const auto moved = [&](const char* name, std::optional<std::size_t> section = {}) {
        const auto *a = find_in(plain, name, section), *b = find_in(leaning, name, section);
        EXPECT_TRUE(a && a->value && b && b->value) << name << (b != nullptr ? b->note : "");
        return a && a->value && b && b->value ? *b->value - *a->value : std::nan("");
    };
    // The plan's centres carry what the lean does in the plane, which is the same in both.
    EXPECT_NEAR(moved("lean_x"), 0.04, 1e-4);
    EXPECT_NEAR(moved("lean_y"), -0.02, 1e-4);
    EXPECT_NEAR(moved("bow_true_position", 1), 0.06, 4e-3);
    EXPECT_NEAR(moved("relative_twist", 2), 0.0, 1e-4);
    EXPECT_GT(moved("generatrix_pressure_0.4"), 1e-3);
    const auto json = nlohmann::json::parse(result_json(leaning));
    ASSERT_EQ(json["characteristics"].size(), 6U);
    EXPECT_TRUE(json["characteristics"][0]["section"].is_null());
    EXPECT_EQ(json["characteristics"][2]["section"], 1);
    const auto csv = part_csv(leaning);
    EXPECT_TRUE(holds(csv, "lean_x,,mm,0."));
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 7);
    EXPECT_TRUE(holds(report_html(leaning), "<td>part</td>"));
}

}  // namespace
}  // namespace cmm::acquisition
