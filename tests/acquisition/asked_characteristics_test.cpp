// SPDX-License-Identifier: Apache-2.0
#include "acquisition/asked_characteristics.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <string>

#include "acquisition/evaluation.hpp"
#include "acquisition/exports.hpp"
#include "acquisition/part_file.hpp"
#include "core/units.hpp"
#include "fitting/area_measures.hpp"
#include "tests/acquisition/synthetic_blade.hpp"

namespace cmm::acquisition {
namespace {

using core::rad_from_deg;
using synthetic::Section;
using synthetic::Shape;

std::string part_with(const std::string& characteristics) {
    return "[part]\nname = \"u\"\n[nominal]\nkind = \"none\"\n[scan]\nheights_mm = [1]\nbox_mm = [-1, -1, 1, 1]\n" +
           characteristics;
}

std::vector<CharacteristicSpec> asked(const std::string& characteristics) {
    const auto part = parse_part_file(part_with(characteristics), "p.toml");
    EXPECT_TRUE(part) << part.error().text();
    return part ? part->gate.characteristics : std::vector<CharacteristicSpec>{};
}

std::string error_of(const std::string& characteristics) {
    const auto part = parse_part_file(part_with(characteristics), "p.toml");
    return part ? "" : part.error().message;
}

/// The synthetic blade thicker by `more` all round and off by `form` besides, turned and moved.
SectionResult judged(const std::vector<CharacteristicSpec>& specs, double more, double turn_rad,
                     const Eigen::Vector2d& shift, bool with_nominal = true,
                     const std::function<double(const fitting::ContourPoint&)>& form = {}) {
    const Shape shape;
    const Section section(shape);
    const auto nominal = fitting::analyse_nominal(synthetic::positions(section.contour()));
    EXPECT_TRUE(nominal);
    const auto plain = synthetic::reference(section, 0.0);
    auto fit = synthetic::fit_of(section, shape, [&](const auto& point) { return more + (form ? form(point) : 0.0); });
    const Eigen::Rotation2Dd turn(turn_rad);
    // About the nominal's centre of area, as the best fit tells it.
    const auto of_nominal = section_of_nominal(*nominal);
    const fitting::MeasuredSection measured(of_nominal);
    const auto area = fitting::measure_area(measured);
    const Eigen::Vector2d centre(area.centroid_x.value, area.centroid_y.value);
    const auto moved = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
        return turn * (p - centre) + centre + shift;
    };
    double arc = 0.0;
    for (std::size_t i = 0; i < fit.contour.size(); ++i) {
        auto& point = fit.contour[i];
        point.position_mm = moved(point.position_mm);
        point.normal = turn * point.normal;
        if (i > 0) arc += (point.position_mm - fit.contour[i - 1].position_mm).norm();
        point.arc_length_mm = arc;
    }
    fit.le_point_mm = moved(fit.le_point_mm);
    fit.te_point_mm = moved(fit.te_point_mm);
    fit.le_scale_mm = shape.le_radius_mm + more;
    fit.te_scale_mm = shape.te_radius_mm + more;
    EvaluationOptions options;
    options.asked = specs;
    SectionResult raw;
    raw.points = synthetic::points_of(fit, 1.0, 40.0, 1, 50, 5);
    return evaluate_section(std::move(raw), std::move(fit), with_nominal ? &plain : nullptr, options,
                            with_nominal ? &*nominal : nullptr);
}

TEST(CharacteristicSpec, ReadsNamesMethodsAndTolerances) {
    const auto specs = asked(R"(
[[characteristic]]
name = "CHORD"
method = "TANGENT"
nominal_mm = 60.0
tolerance_mm = 0.1
[[characteristic]]
name = "CHDANG"
nominal_deg = 24.0
lower_deg = -0.2
upper_deg = 0.3
sections = [0, 2]
[[characteristic]]
name = "LETHCK"
distance_mm = 2.5
[[characteristic]]
name = "te_angle"
near_mm = 2
far_mm = 6
reference = "chord"
label = "exit"
[[characteristic]]
name = "cccont"
tolerance_mm = 0.05
)");
    ASSERT_EQ(specs.size(), 5U);
    EXPECT_EQ(specs[0].kind, CharacteristicKind::chord);
    EXPECT_EQ(specs[0].chord, fitting::ChordMethod::caliper);
    EXPECT_EQ(specs[0].label, "chord_tangent");
    EXPECT_DOUBLE_EQ(*specs[0].below, -0.1);
    EXPECT_DOUBLE_EQ(*specs[0].above, 0.1);
    EXPECT_EQ(specs[1].label, "stagger");
    EXPECT_DOUBLE_EQ(*specs[1].nominal, rad_from_deg(24.0));
    EXPECT_DOUBLE_EQ(*specs[1].below, rad_from_deg(-0.2));
    EXPECT_TRUE(specs[1].is_of(2));
    EXPECT_FALSE(specs[1].is_of(1));
    EXPECT_EQ(specs[2].label, "le_thickness_2.5");
    EXPECT_TRUE(specs[2].is_of(77));
    EXPECT_EQ(specs[3].label, "exit");
    EXPECT_EQ(specs[3].reference, fitting::AngleReference::chord);
    EXPECT_EQ(specs[4].kind, CharacteristicKind::profile_form_pressure);
    EXPECT_DOUBLE_EQ(*specs[4].above, 0.05);
    EXPECT_FALSE(specs[4].below);
}

TEST(CharacteristicSpec, SaysWhatIsWrong) {
    const std::string head = "[[characteristic]]\n";
    EXPECT_NE(error_of(head + "name = \"cord\"\n").find("cord"), std::string::npos);
    EXPECT_NE(error_of(head + "name = \"chord\"\nmethod = \"WIDE\"\n").find("NOSETAIL"), std::string::npos);
    EXPECT_NE(error_of(head + "name = \"area\"\nmethod = \"GREEN\"\n").find("method"), std::string::npos);
    EXPECT_NE(error_of(head + "name = \"le_thickness\"\n").find("distance_mm"), std::string::npos);
    EXPECT_NE(error_of(head + "name = \"le_angle\"\nnear_mm = 5\nfar_mm = 2\n").find("near_mm"), std::string::npos);
    EXPECT_NE(error_of(head + "name = \"stagger\"\nnominal_mm = 5\n").find("nominal_mm"), std::string::npos);
    EXPECT_NE(error_of(head + "name = \"chord\"\ntolerance_mm = 1\nlower_mm = -1\n").find("exclude"),
              std::string::npos);
    EXPECT_NE(error_of(head + "name = \"chord\"\nlower_mm = 1\nupper_mm = -1\n").find("less"), std::string::npos);
    EXPECT_NE(error_of(head + "name = \"profile_form_le\"\nlower_mm = 0.1\n").find("zone"), std::string::npos);
    EXPECT_NE(error_of(head + "name = \"chord\"\n" + head + "name = \"chord\"\n").find("twice"), std::string::npos);
    EXPECT_EQ(error_of(head + "name = \"chord\"\nsections=[0]\n" + head + "name = \"chord\"\nsections=[1]\n"), "");
    EXPECT_NE(error_of(head + "name = \"chord\"\nsections=[0.5]\n").find("indices"), std::string::npos);
}

TEST(CharacteristicSpec, AfterAnUnknownNameOrMethodThatAloneIsSaid) {
    const auto cord = error_of("[[characteristic]]\nmethod = \"BELAC\"\nname = \"cord\"\ndirection_deg = 4\n");
    EXPECT_EQ(cord.find("p.toml:10:1: characteristic[0].name \"cord\" is none of chord, "), 0U) << cord;
    EXPECT_NE(cord.find("; did you mean \"chord\"?"), std::string::npos) << cord;
    const auto belca = error_of("[[characteristic]]\nname = \"chord\"\ndirection_deg = 4\nmethod = \"BELCA\"\n");
    EXPECT_EQ(belca.find("p.toml:11:1: characteristic[0].method \"BELCA\" is none of"), 0U) << belca;
    const auto nam = error_of("[[characteristic]]\nnam = \"throat\"\ndirection_deg = 4\n");
    EXPECT_EQ(nam, "p.toml:9:1: unknown key characteristic[0].nam; did you mean \"name\"?");
}

TEST(AskedCharacteristics, TakeTheirNominalFromTheNominalSection) {
    const auto specs = asked(R"(
[[characteristic]]
name = "chord"
tolerance_mm = 0.1
[[characteristic]]
name = "chord"
method = "caliper"
tolerance_mm = 0.03
[[characteristic]]
name = "chord"
method = "RADCENTER"
tolerance_mm = 0.1
[[characteristic]]
name = "max_thickness"
tolerance_mm = 0.1
[[characteristic]]
name = "axial_chord"
[[characteristic]]
name = "le_thickness"
distance_mm = 4
upper_mm = 0.1
[[characteristic]]
name = "le_radius"
tolerance_mm = 0.001
)");
    const double more = 0.02;
    const auto result = judged(specs, more, 0.0, {0, 0});
    const Shape shape;
    const Section section(shape);
    const auto* chord = result.find("chord");
    ASSERT_TRUE(chord && chord->value && chord->nominal) << chord->note;
    // The edges are circles about the ends of the camber line: the points on them lie on its continuation.
    EXPECT_NEAR(*chord->nominal, (section.nose() - section.tail()).norm(), 2e-3);
    EXPECT_NEAR(*chord->value - *chord->nominal, 2.0 * more * std::cos(0.5 * shape.camber_rad), 1e-3);
    EXPECT_EQ(chord->decision, Decision::accept);
    EXPECT_DOUBLE_EQ(*chord->upper, *chord->nominal + 0.1);
    const auto* caliper = result.find("chord_caliper");
    ASSERT_TRUE(caliper && caliper->value);
    EXPECT_NEAR(*caliper->value - *caliper->nominal, 2.0 * more, 1e-4);
    EXPECT_EQ(caliper->decision, Decision::reject);
    const auto* centres = result.find("chord_radcenter");
    ASSERT_TRUE(centres && centres->value && centres->nominal) << centres->note;
    EXPECT_NEAR(*centres->nominal,
                (section.edge_centre(1.0) - section.edge_centre(0.0)).norm() + shape.le_radius_mm + shape.te_radius_mm,
                1e-3);
    EXPECT_EQ(centres->decision, Decision::accept);
    const auto* thickness = result.find("max_thickness");
    ASSERT_TRUE(thickness && thickness->value);
    EXPECT_NEAR(*thickness->value - *thickness->nominal, 2.0 * more, 1e-4);
    // Nothing is known of how the errors go together: both sides' U95 in full.
    EXPECT_NEAR(*thickness->u95, 2.0 * 0.0007, 1e-6);
    EXPECT_EQ(result.find("axial_chord")->decision, Decision::reported);
    const auto* edge = result.find("le_thickness_4");
    ASSERT_TRUE(edge && edge->value) << (edge ? edge->note : "");
    EXPECT_EQ(edge->decision, Decision::accept);
    EXPECT_FALSE(edge->lower);
    const auto* radius = result.find("le_radius");
    EXPECT_NEAR(*radius->nominal, shape.le_radius_mm, 1e-3);
    EXPECT_EQ(radius->decision, Decision::undecided) << "0.0021 of U95 against 0.001";
    EXPECT_EQ(std::count_if(result.characteristics.begin(), result.characteristics.end(),
                            [](const auto& c) { return c.name == "chord"; }),
              1);
}

TEST(AskedCharacteristics, FormIsJudgedAfterTheBestFitAndLocationByIt) {
    const auto specs = asked(R"(
[[characteristic]]
name = "twist"
tolerance_deg = 0.1
[[characteristic]]
name = "displacement_x"
tolerance_mm = 0.2
[[characteristic]]
name = "displacement_y"
[[characteristic]]
name = "profile_form_suction"
tolerance_mm = 0.01
)");
    const double turn = rad_from_deg(0.3);
    const auto result = judged(specs, 0.0, turn, {0.05, -0.03});
    const auto* twist = result.find("twist");
    ASSERT_TRUE(twist && twist->value) << twist->note;
    EXPECT_EQ(twist->unit, Unit::rad);
    EXPECT_NEAR(*twist->value, turn, 2e-6);
    EXPECT_EQ(twist->decision, Decision::reject);
    EXPECT_NEAR(*result.find("displacement_x")->value, 0.05, 2e-4);
    EXPECT_NEAR(*result.find("displacement_y")->value, -0.03, 2e-4);
    EXPECT_EQ(result.find("displacement_x")->decision, Decision::accept);
    const auto *form = result.find("profile_form_suction"), *both = result.find("profile_suction");
    ASSERT_TRUE(form->value && both->value);
    EXPECT_LT(*form->value, 2e-3);
    EXPECT_GT(*both->value, 0.1);
    EXPECT_EQ(form->decision, Decision::accept);
}

TEST(AskedCharacteristics, RadiiInAWindowSayTheirArc) {
    const auto specs = asked(R"(
[[characteristic]]
name = "le_radius"
arc_deg = 100
tolerance_mm = 0.05
[[characteristic]]
name = "te_radius"
reach_mm = 0.3
[[characteristic]]
name = "le_radius"
label = "of_too_little"
reach_mm = 0.05
tolerance_mm = 0.05
)");
    const auto result = judged(specs, 0.01, 0.0, {0, 0});
    const auto* le = result.find("le_radius_arc_100");
    ASSERT_TRUE(le && le->value && le->u95);
    EXPECT_NEAR(*le->value, Shape().le_radius_mm + 0.01, 2e-4);
    EXPECT_NEAR(*le->nominal, Shape().le_radius_mm, 2e-4);
    EXPECT_NE(le->note.find("arc of 100 deg, rms"), std::string::npos) << le->note;
    EXPECT_EQ(le->decision, Decision::accept);
    const auto* te = result.find("te_radius_reach_0.3");
    EXPECT_NEAR(*te->value, Shape().te_radius_mm + 0.01, 2e-3);
    EXPECT_NE(te->note.find("within 0.300 mm of the nose"), std::string::npos) << te->note;
    const auto* refused = result.find("of_too_little");
    EXPECT_EQ(refused->decision, Decision::not_evaluable);
    EXPECT_NE(refused->note.find("(60 degrees)"), std::string::npos) << refused->note;
    EXPECT_NE(error_of("[[characteristic]]\nname = \"le_radius\"\narc_deg = 45\n").find("from 65 to 300"),
              std::string::npos);
    EXPECT_NE(error_of("[[characteristic]]\nname = \"le_radius\"\narc_deg = 90\nreach_mm = 1\n").find("exclude"),
              std::string::npos);
}

TEST(AskedCharacteristics, ABestFitTakesTheZonesThatItIsTold) {
    // The pressure side stands 40 um out everywhere: a fit of all zones follows it, one of the suction side does not.
    const auto thick = [](const fitting::ContourPoint& point) {
        return point.zone == fitting::Zone::pressure ? 0.04 : 0.0;
    };
    const auto specs = asked(R"(
[[characteristic]]
name = "profile_form_suction"
[[characteristic]]
name = "profile_form_suction"
label = "by_suction"
fit_zones = ["suction", "le"]
[[characteristic]]
name = "twist"
fit_zones = ["suction", "le"]
)");
    const double turn = rad_from_deg(0.2);
    const auto result = judged(specs, 0.0, turn, {0.05, -0.03}, true, thick);
    EXPECT_GT(*result.find("profile_form_suction")->value, 0.02);
    EXPECT_LT(*result.find("by_suction")->value, 3e-3);
    EXPECT_NEAR(*result.find("twist")->value, turn, 2e-5);
    EXPECT_NE(result.find("twist")->method.find("best fit of le suction"), std::string::npos);
    EXPECT_EQ(result.find("profile_form_suction")->method.find("best fit of le"), std::string::npos);
}

TEST(AskedCharacteristics, FormZonesEndWhereTheyAreToldTo) {
    // A bump of 20 um on the suction side, 4 mm from the leading edge.
    const Section section{Shape()};
    const auto bump = [&](const fitting::ContourPoint& point) {
        const double far_mm = (point.position_mm - section.nose()).norm();
        return point.zone == fitting::Zone::suction ? 0.02 * std::exp(-std::pow((far_mm - 4.0) / 0.5, 2)) : 0.0;
    };
    const auto forms = [&](const std::string& keys) {
        std::string text;
        for (const char* zone : {"le", "suction", "te", "pressure"})
            text +=
                "[[characteristic]]\nname = \"profile_form_" + std::string(zone) + "\"\ntolerance_mm = 0.03\n" + keys;
        const auto result = judged(asked(text), 0.0, rad_from_deg(0.2), {0.03, -0.02}, true, bump);
        std::map<std::string, double> values;
        for (const char* zone : {"le", "suction", "te", "pressure"})
            values[zone] = result.find("profile_form_" + std::string(zone))->value.value_or(-1.0);
        return values;
    };
    auto by_edges = forms("");
    EXPECT_LT(by_edges["le"], 0.005);
    EXPECT_NEAR(by_edges["suction"], 0.04, 0.003);
    auto reaching = forms("le_change_mm = 6\nte_change_mm = 1\n");
    EXPECT_NEAR(reaching["le"], 0.04, 0.003);
    EXPECT_LT(reaching["suction"], 0.005);
    EXPECT_GE(reaching["te"], 0.0);
    // Short of the bump, and shorter than the edge itself: what is left of that is side.
    auto short_edge = forms("le_change_mm = 0.1\n");
    EXPECT_NEAR(short_edge["suction"], 0.04, 0.003);
    EXPECT_LT(short_edge["le"], 0.005);
    EXPECT_NE(error_of("[[characteristic]]\nname = \"chord\"\nle_change_mm = 2\n").find("le_change_mm"),
              std::string::npos);
}

TEST(AskedCharacteristics, SayWhyTheyCannotBeEvaluated) {
    const auto specs = asked(R"(
[[characteristic]]
name = "twist"
tolerance_deg = 0.1
[[characteristic]]
name = "chord"
tolerance_mm = 0.1
[[characteristic]]
name = "le_thickness"
distance_mm = 500
)");
    const auto result = judged(specs, 0.0, 0.0, {0, 0}, false);
    EXPECT_EQ(result.find("twist")->decision, Decision::not_evaluable);
    EXPECT_NE(result.find("twist")->note.find("no nominal"), std::string::npos);
    EXPECT_EQ(result.find("chord")->decision, Decision::not_evaluable);
    EXPECT_NE(result.find("chord")->note.find("nominal"), std::string::npos);
    EXPECT_EQ(result.find("le_thickness_500")->decision, Decision::not_evaluable);
    EXPECT_NE(result.find("le_thickness_500")->note.find("reach"), std::string::npos);
    EXPECT_EQ(result.decision(), Decision::undecided) << "a requirement that cannot be evaluated";
    EvaluationOptions options;
    options.asked = specs;
    const auto open = evaluate_section({}, core::fail(core::ErrorCode::fit_not_evaluable, "open"), nullptr, options);
    EXPECT_EQ(open.find("twist")->decision, Decision::not_evaluable);
    EXPECT_NE(open.find("chord")->note.find("open"), std::string::npos);
}

TEST(AskedCharacteristics, LimitsAreNotMadeUpWhereTheNominalIsNotKnown) {
    EvaluationOptions options;
    options.asked = asked(R"(
[[characteristic]]
name = "chord"
tolerance_mm = 0.1
[[characteristic]]
name = "stagger"
nominal_deg = 24.0
tolerance_deg = 0.2
[[characteristic]]
name = "twist"
tolerance_deg = 0.1
)");
    const auto open = evaluate_section({}, core::fail(core::ErrorCode::fit_not_evaluable, "open"), nullptr, options);
    const auto without = judged(options.asked, 0.0, 0.0, {0, 0}, false);
    for (const auto* section : {&open, &without}) {
        const auto* chord = section->find("chord");
        EXPECT_EQ(chord->decision, Decision::not_evaluable);
        EXPECT_FALSE(chord->nominal || chord->has_limits()) << "there is no nominal to measure limits from";
        EXPECT_TRUE(chord->has_requirement());
        EXPECT_NEAR(*section->find("stagger")->upper, rad_from_deg(24.2), 1e-12);
        EXPECT_NEAR(*section->find("twist")->upper, rad_from_deg(0.1), 1e-12);
    }
    EXPECT_EQ(open.find("stagger")->decision, Decision::not_evaluable);
    EXPECT_EQ(open.decision(), Decision::undecided);
}

TEST(AskedCharacteristics, AreInEveryOutput) {
    PartResult part;
    part.part_name = "p";
    part.sections.push_back(judged(asked("[[characteristic]]\nname = \"stagger\"\ntolerance_deg = 0.2\n"
                                         "[[characteristic]]\nname = \"area\"\n"
                                         "[[characteristic]]\nname = \"max_thickness_position\"\n"),
                                   0.0, rad_from_deg(0.5), {0, 0}));
    const auto csv = sections_csv(part);
    EXPECT_NE(csv.find(",stagger_deg,stagger_u95_deg,stagger_decision,area_mm2,area_u95_mm2,area_decision,"
                       "max_thickness_position,max_thickness_position_u95,"),
              std::string::npos)
        << csv.substr(0, csv.find('\n'));
    const auto json = result_json(part);
    EXPECT_NE(json.find("\"name\": \"stagger\""), std::string::npos);
    EXPECT_NE(json.find("\"unit\": \"rad\""), std::string::npos);
    EXPECT_NE(report_html(part).find("NOSETAIL"), std::string::npos);
    const auto reasons = verdict_reasons(part);
    ASSERT_EQ(reasons.size(), 1U);
    EXPECT_NE(reasons[0].find("stagger"), std::string::npos);
    EXPECT_NE(reasons[0].find(" deg > "), std::string::npos) << reasons[0];
}

}  // namespace
}  // namespace cmm::acquisition
