// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exports.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "acquisition/evaluation.hpp"
#include "acquisition/section_figures.hpp"
#include "core/text.hpp"
#include "tests/acquisition/count_of.hpp"
#include "tests/acquisition/judged_part.hpp"
#include "tests/acquisition/temp_folder.hpp"

namespace cmm::acquisition {
namespace {

namespace fs = std::filesystem;
std::vector<std::vector<std::string_view>> rows_of(const std::string& csv) {
    std::vector<std::vector<std::string_view>> rows;
    std::string_view rest(csv);
    while (!rest.empty()) {
        const auto end = rest.find('\n');
        rows.push_back(core::split(rest.substr(0, end), ','));
        rest.remove_prefix(end + 1);
    }
    return rows;
}

TEST(SectionCsv, IsTheContourOfTheContract) {
    const auto section = section_at(0, 0.0);
    const auto csv = section_csv(section);
    const auto rows = rows_of(csv);
    EXPECT_EQ(csv.substr(0, csv.find('\n')), "x_mm,y_mm,z_mm,nx,ny,nz,zone,deviation_mm,u95_mm");
    ASSERT_GE(rows.size(), 2001U);
    double doubled_area = 0.0;
    std::set<std::string_view> zones;
    const auto number = [&](std::size_t row, std::size_t column) {
        return core::parse_number(rows[row][column]).value();
    };
    for (std::size_t i = 1; i < rows.size(); ++i) {
        ASSERT_EQ(rows[i].size(), 9U);
        const auto next = i + 1 < rows.size() ? i + 1 : 1;
        doubled_area += number(i, 0) * number(next, 1) - number(next, 0) * number(i, 1);
        zones.insert(rows[i][6]);
        ASSERT_NEAR(std::hypot(number(i, 3), number(i, 4)), 1.0, 1e-8);
        ASSERT_EQ(number(i, 5), 0.0);
        ASSERT_EQ(number(i, 2), 10.0);
        ASSERT_NEAR(number(i, 7), section.deviation_mm[i - 1].value(), 1e-6);
    }
    EXPECT_GT(doubled_area, 100.0) << "counter-clockwise";
    EXPECT_EQ(zones, (std::set<std::string_view>{"le", "suction", "te", "pressure"}));
}

TEST(SectionCsv, DeviationIsEmptyWithoutANominal) {
    const auto csv = section_csv(section_at(0, 0.0, false));
    const auto rows = rows_of(csv);
    ASSERT_GT(rows.size(), 2000U);
    for (std::size_t i = 1; i < rows.size(); ++i)
        ASSERT_EQ(rows[i][7], "");
    EXPECT_EQ(section_csv(open_section(0)), "");
}

TEST(SectionsCsv, NamesWithCommasAndQuotesAreQuoted) {
    auto section = section_at(0, 0.0);
    Characteristic c;
    c.name = "a, \"b\"";
    section.characteristics = {c};
    const auto csv = sections_csv(part_of({section}));
    EXPECT_NE(csv.find(",\"a, \"\"b\"\"_mm\",\"a, \"\"b\"\"_u95_mm\",\"a, \"\"b\"\"_decision\"\n"), std::string::npos)
        << csv;
}

TEST(SectionsCsv, HasARowASectionAndThreeColumnsACharacteristic) {
    const std::vector<SectionResult> sections{section_at(0, 0.0), section_at(1, 0.2), open_section(2)};
    const auto csv = sections_csv(part_of(sections));
    const auto rows = rows_of(csv);
    ASSERT_EQ(rows.size(), 4U);
    const auto& head = rows[0];
    EXPECT_EQ(csv.substr(0, csv.find(",profile")), "index,z_mm,points,rejected,closed");
    for (const auto& row : rows)
        ASSERT_EQ(row.size(), 5U + 3U * 8U);
    const auto column = [&](std::string_view name) {
        return static_cast<std::size_t>(std::find(head.begin(), head.end(), name) - head.begin());
    };
    EXPECT_NEAR(*core::parse_number(rows[2][column("profile_pressure_mm")]), 0.406, 0.001);
    EXPECT_NEAR(*core::parse_number(rows[2][column("profile_pressure_u95_mm")]),
                *sections[1].find("profile_pressure")->u95, 1e-6);
    EXPECT_EQ(rows[2][column("profile_pressure_decision")], "reject");
    EXPECT_EQ(rows[1][column("profile_pressure_decision")], "accept");
    EXPECT_EQ(rows[1][column("max_thickness_decision")], "reported");
    EXPECT_EQ(rows[1][column("closed")], "1");
    EXPECT_EQ(rows[3][column("closed")], "0");
    EXPECT_EQ(rows[3][column("chord_mm")], "");
    EXPECT_EQ(rows[3][column("chord_decision")], "not_evaluable");
    EXPECT_EQ(rows[1][column("rejected")], "4");
}

TEST(RejectedCsv, NamesEveryRejectedPoint) {
    const auto section = section_at(0, 0.0);
    const auto csv = rejected_csv(part_of({section}));
    const auto rows = rows_of(csv);
    EXPECT_EQ(csv.substr(0, csv.find('\n')), "section,seq,x_mm,y_mm,z_mm,residual_mm,reason");
    ASSERT_EQ(rows.size(), 1U + section.rejected());
    const auto& bad = section.points[50];
    EXPECT_EQ(rows[1][0], "0");
    EXPECT_EQ(rows[1][1], "51");
    EXPECT_NEAR(*core::parse_number(rows[1][2]), bad.centre_mm.x(), 1e-6);
    EXPECT_NEAR(*core::parse_number(rows[1][5]), bad.verdict.residual_mm, 1e-6);
    EXPECT_EQ(rows[1][6], "fit_residual");
}

TEST(ResultJson, CarriesMethodAndUncertaintyWithEveryNumber) {
    auto part = part_of({section_at(0, 0.0), section_at(1, 0.2), open_section(2)});
    part.part_name = "caf\xE9 \x01";  // not UTF-8
    const auto json = nlohmann::json::parse(result_json(part));
    EXPECT_EQ(json.at("schema"), "cmmlive-result");
    EXPECT_EQ(json.at("schema_version"), 1);
    EXPECT_EQ(json.at("verdict"), "reject");
    EXPECT_EQ(json.at("reasons").size(), 2U);
    EXPECT_EQ(json.at("run").at("ball_radius_mm"), 1.0);
    ASSERT_EQ(json.at("sections").size(), 3U);
    for (const auto& section : json.at("sections")) {
        for (const auto& c : section.at("characteristics")) {
            EXPECT_FALSE(c.at("method").get<std::string>().empty());
            EXPECT_EQ(c.at("value_mm").is_null(), c.at("u95_mm").is_null());
            EXPECT_EQ(c.at("value_mm").is_null(), c.at("decision") == "not_evaluable");
        }
        EXPECT_EQ(section.at("rejected_points").size(), section.at("rejected"));
    }
    EXPECT_EQ(json.at("sections")[2].at("why"), "gap of 3.2 mm");
    EXPECT_EQ(json.at("sections")[1].at("characteristics")[3].at("limit_mm"), 0.1);
}

/// A part of which the machine is known: one budget.
PartResult part_with_budget() {
    auto part = part_of({section_at(0, 0.0), section_at(1, 0.0)});
    part.uncertainty.machine.length_mm = 1.9e-3;
    part.uncertainty.machine.probing_size_mm = 1.2e-3;
    for (auto& section : part.sections) {
        for (auto& c : section.characteristics) {
            if (c.name != "chord") continue;
            c.budget = fitting::ErrorBudget{0.0004, {0.0008, 0.0003, 0.0011, 0.0}, 0.0002};
            c.u95 = 0.003 + 0.001 * static_cast<double>(section.index);
        }
    }
    return part;
}

TEST(ResultJson, SaysWhereAnUncertaintyComesFrom) {
    const auto json = nlohmann::json::parse(result_json(part_with_budget()));
    EXPECT_EQ(json.at("uncertainty").at("figures").at("length_mm"), 0.0019);
    EXPECT_TRUE(json.at("uncertainty").at("figures").at("probing_form_mm").is_null());
    EXPECT_NEAR(json.at("uncertainty").at("standard").at("ball_mm").get<double>(), 0.6e-3 / std::sqrt(3.0), 1e-8);
    std::size_t budgets = 0;
    for (const auto& c : json.at("sections").at(1).at("characteristics")) {
        if (!c.contains("budget")) continue;
        ++budgets;
        EXPECT_EQ(c.at("name"), "chord");
        EXPECT_EQ(c.at("budget"), nlohmann::json({{"noise", 0.0004},
                                                  {"ball", 0.0008},
                                                  {"probing", 0.0003},
                                                  {"length", 0.0011},
                                                  {"temperature", 0.0},
                                                  {"added", 0.0002}}));
    }
    EXPECT_EQ(budgets, 1U);
    const auto plain = nlohmann::json::parse(result_json(part_of({section_at(0, 0.0)})));
    EXPECT_FALSE(plain.contains("uncertainty"));
    EXPECT_FALSE(plain.at("sections").at(0).at("characteristics").at(0).contains("budget"));
}

TEST(ReportHtml, ShowsWhatDominatesAnUncertainty) {
    const auto html = report_html(part_with_budget());
    EXPECT_NE(html.find("Where the uncertainties come from"), std::string::npos);
    // In micrometres, of the section with the larger U95, the largest part bold.
    EXPECT_NE(html.find("<tr><td class=\"word\">chord</td><td>1</td><td>\u00b5m</td><td>0.40</td><td>0.80</td>"
                        "<td>0.30</td><td><b>1.10</b></td><td>0.00</td><td>0.20</td><td>4.00</td></tr>"),
              std::string::npos);
    EXPECT_NE(html.find("E0 1.9 um"), std::string::npos);
    EXPECT_EQ(html.find("length error is not included"), std::string::npos);
    const auto plain = report_html(part_of({section_at(0, 0.0)}));
    EXPECT_EQ(plain.find("Where the uncertainties come from"), std::string::npos);
    EXPECT_NE(plain.find("length error is not included"), std::string::npos);
}

TEST(ReportHtml, IsOneFileWithEscapedNamesAndAllPictures) {
    const auto part = part_of({section_at(0, 0.0), section_at(1, 0.2)});
    const auto html = report_html(part);
    EXPECT_EQ(html.find("rotor <1>"), std::string::npos);
    EXPECT_NE(html.find("rotor &lt;1&gt; &amp; &quot;co&quot;"), std::string::npos);
    EXPECT_EQ(html.find("<script"), std::string::npos);
    EXPECT_EQ(html.find("src="), std::string::npos);
    EXPECT_EQ(html.find("@import"), std::string::npos);
    EXPECT_EQ(html.find("nan"), std::string::npos);
    EXPECT_EQ(count_of(html, "<article"), 2U);
    EXPECT_EQ(count_of(html, "deviations \u00d7 "), 2U) << "the magnification is stated";
    EXPECT_EQ(count_of(html, "deviation in \u00b5m"), 2U);
    EXPECT_EQ(count_of(html, ">z in mm<"), 9U) << "a trend for each characteristic, and the map";
    EXPECT_EQ(count_of(html, "fit residual"), 8U) << "rejected points with their reason";
    EXPECT_NE(html.find("class=\"whisker-out\""), std::string::npos);
    EXPECT_NE(html.find("prefers-color-scheme:dark"), std::string::npos);
    EXPECT_LT(html.size() / part.sections.size(), 200'000U) << "fifteen sections stay below 3 MB";
    EXPECT_EQ(count_of(html, "<svg"), count_of(html, "</svg>"));
    EXPECT_EQ(count_of(html, "<div"), count_of(html, "</div>"));
}

/// The colours where the part is as thick as it should be, and where it is 0.2 mm thicker than its zone of 0.1 mm.
TEST(DeviationMap, ShowsEachSectionAsAStripInTheColourOfItsDeviation) {
    const std::string neutral = "#f2f2f2", most = "#b2182b", least = "#2166ac";
    const auto scale_boxes = [](const std::string& text, const std::string& colour) {
        return count_of(text, "fill:" + colour);
    };
    const auto good = map_figure(part_of({section_at(0, 0.0), section_at(1, 0.0)}));
    EXPECT_EQ(scale_boxes(good, neutral), 2U) << "its strips and the scale";
    EXPECT_EQ(scale_boxes(good, most), 1U) << "the scale alone";
    const auto thick = map_figure(part_of({section_at(0, 0.0), section_at(1, 0.2)}));
    EXPECT_EQ(scale_boxes(thick, most), 2U);
    EXPECT_EQ(scale_boxes(thick, least), 1U);
    EXPECT_NE(thick.find("+50<"), std::string::npos) << "the scale ends at half the zone";
    EXPECT_NE(thick.find("SUCTION SIDE"), std::string::npos);
    EXPECT_EQ(thick.find("nan"), std::string::npos);
    EXPECT_TRUE(map_figure(part_of({})).empty());
}

TEST(DeviationMap, WhatTheBallDoesNotReachHasNoColour) {
    auto section = section_at(0, 0.0);
    ASSERT_EQ(map_figure(part_of({section})).find("unknown"), std::string::npos);
    for (std::size_t i = 100; i < 140; ++i)
        section.deviation_mm[i].reset();
    EXPECT_NE(map_figure(part_of({section})).find("unknown"), std::string::npos);
}

TEST(DeviationMap, IsAFileOfItsOwn) {
    TempFolder folder;
    ASSERT_TRUE(export_svg(part_of({section_at(0, 0.1)}), folder.path("map.svg")));
    const auto text = core::read_file(folder.path("map.svg")).value();
    EXPECT_TRUE(text.starts_with("<svg xmlns="));
    EXPECT_NE(text.find("<style>"), std::string::npos);
    EXPECT_EQ(export_svg(part_of({}), folder.path("none.svg")).error().code, core::ErrorCode::input_invalid);
}

TEST(ReportHtml, ANameThatIsTheNumberIsNotRepeated) {
    auto part = part_of({section_at(0, 0.0), section_at(1, 0.0)});
    part.sections[0].name = "0";
    part.sections[1].name = "rotor_z<20>";
    const auto html = report_html(part);
    EXPECT_EQ(count_of(html, ">from "), 1U);
    EXPECT_NE(html.find(">from rotor_z&lt;20&gt;<"), std::string::npos);
}

TEST(ReportHtml, ARadiusHasOneUncertainty) {
    auto part = part_of({section_at(0, 0.0)});
    const auto* radius = part.sections[0].find("le_radius");
    ASSERT_NE(radius, nullptr);
    const auto html = report_html(part);
    const auto value = core::fixed(*radius->value, 4);
    const auto u95 = core::fixed(*radius->u95, 4);
    EXPECT_EQ(count_of(html, "r " + value + " \u00b1 " + u95 + " mm"), 1U) << "in the caption";
    EXPECT_EQ(count_of(html, value + "<small>\u00b1 " + u95 + "</small>"), 1U) << "in the table";
}

TEST(ReportHtml, BearsOpenSectionsMissingNominalsAndNothing) {
    auto part = part_of({open_section(0), section_at(1, 0.0, false)});
    const auto html = report_html(part);
    EXPECT_NE(html.find("Not evaluable: gap of 3.2 mm"), std::string::npos);
    EXPECT_EQ(html.find("nan"), std::string::npos);
    EXPECT_EQ(html.find("inf "), std::string::npos);
    EXPECT_NE(report_html(part_of({})).find("no section was measured"), std::string::npos);
    SectionResult bare;
    bare.why = "no points";
    EXPECT_NE(report_html(part_of({bare})).find("no points"), std::string::npos);
}

TEST(Summary, EndsWithTheVerdictAndItsReasons) {
    const auto text = summary_text(part_of({section_at(0, 0.0), section_at(1, 0.1)}));
    EXPECT_NE(text.find("sides mm <= 0.100"), std::string::npos) << text;
    EXPECT_NE(text.find("edges mm <= 0.060"), std::string::npos);
    EXPECT_NE(text.find("0.206 !"), std::string::npos) << text;
    EXPECT_NE(text.find("\nverdict: REJECT\n  section 1 (z 20.0): profile_pressure 0.206 mm +- 0.002 mm > 0.100 mm\n"),
              std::string::npos)
        << text;
    EXPECT_NE(summary_text(part_of({section_at(0, 0.0, false)})).find("verdict: DONE\n"), std::string::npos);
    EXPECT_NE(summary_text(part_of({open_section(0)})).find("verdict: UNDECIDED\n"), std::string::npos);
}

TEST(WriteOutputs, MakesTheFilesOfTheContract) {
    const TempFolder folder;
    const auto dir = folder.path("a/b");
    ASSERT_TRUE(write_outputs(part_of({section_at(0, 0.0), open_section(1)}), dir));
    for (const auto* name : {"sections.csv", "rejected.csv", "section-0.csv", "result.json", "report.html"}) {
        EXPECT_TRUE(fs::exists(dir + "/" + name)) << name;
    }
    EXPECT_FALSE(fs::exists(dir + "/section-1.csv")) << "an open section has no contour";
    const auto refused = write_outputs(part_of({}), dir + "/result.json/sub");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, core::ErrorCode::journal_io);
}

}  // namespace
}  // namespace cmm::acquisition
