// SPDX-License-Identifier: Apache-2.0
/// Sections that were measured in part, judged: what was not measured is neither shown nor decided.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "acquisition/exports.hpp"
#include "tests/acquisition/count_of.hpp"
#include "tests/acquisition/gapped_part.hpp"

namespace cmm::acquisition {
namespace {

/// The leaning blade, judged without the points of its middle section that are missing.
PartResult judged_without(const Missing& missing, const std::string& gate,
                          const std::vector<std::size_t>& sections = {1}, double thicken_mm = 0.0,
                          bool laid_onto_nominal = true, std::size_t count = 3) {
    std::string text = leaning_text(gate);
    const std::string alignment = "[alignment]\nkind = \"section\"\n";
    if (!laid_onto_nominal) text.erase(text.find(alignment), alignment.size());
    return judged_part_without(missing, text, sections, thicken_mm, count);
}

const std::string judged = "profile_mm = 0.2\nedge_profile_mm = 0.2\n";

TEST(SectionGaps, WhatRestsOnAGapIsNotEvaluableAndTheRestIs) {
    const auto part = judged_without(on_suction_side, judged);
    const SectionResult& section = part.sections[1];
    ASSERT_TRUE(section.has_contour()) << section.why;
    ASSERT_EQ(section.gaps().size(), 1U);
    EXPECT_NEAR(section.gaps()[0].length_mm, 8.5 + 2 * 4 * 0.5, 1.0);  // four points on either side
    EXPECT_EQ(section.find("profile_suction")->decision, Decision::undecided);
    EXPECT_NE(section.find("profile_suction")->note.find("not measured"), std::string::npos);
    EXPECT_EQ(section.find("profile_pressure")->decision, Decision::accept) << section.find("profile_pressure")->note;
    EXPECT_EQ(section.find("profile_le")->decision, Decision::accept);
    EXPECT_TRUE(section.find("le_radius")->value) << section.find("le_radius")->note;
    EXPECT_FALSE(section.find("max_thickness")->value) << "the thickest place lies in the gap";
    EXPECT_NE(section.find("max_thickness")->note.find("gap"), std::string::npos);
    EXPECT_EQ(part.verdict(), Decision::undecided);
    const auto reasons = verdict_reasons(part);
    ASSERT_EQ(reasons.size(), 1U);
    EXPECT_NE(reasons[0].find("part of it was not"), std::string::npos) << reasons[0];
}

TEST(SectionGaps, WhatWasMeasuredRejects) {
    const auto part = judged_without(on_suction_side, judged, {1}, 0.15);
    EXPECT_EQ(part.sections[1].find("profile_suction")->decision, Decision::reject);
    EXPECT_EQ(part.verdict(), Decision::reject);
}

TEST(SectionGaps, APartOfWhichNothingIsRequiredIsNotDone) {
    const auto part = judged_without(on_suction_side, "");
    EXPECT_EQ(part.sections[0].decision(), Decision::reported);
    EXPECT_EQ(part.sections[1].decision(), Decision::undecided);
    const auto reasons = verdict_reasons(part);
    ASSERT_EQ(reasons.size(), 1U);
    EXPECT_NE(reasons[0].find("were not measured"), std::string::npos) << reasons[0];
}

TEST(SectionGaps, WhereNothingIsRequiredASmallGapIsOnlyReported) {
    for (const std::size_t missing : {0U, 4U, 6U}) {
        SectionResult section;
        section.fit.emplace();
        for (std::size_t i = 0; i <= 100; ++i) {
            fitting::ContourPoint point;
            point.arc_length_mm = 0.5 * static_cast<double>(i);
            point.measured = i < 40 || i >= 40 + missing;
            section.fit->contour.push_back(point);
        }
        EXPECT_EQ(section.decision(), missing < 6 ? Decision::reported : Decision::undecided) << missing;
    }
}

TEST(SectionGaps, FilesAndPicturesShowNothingThere) {
    const auto part = judged_without(on_suction_side, judged);
    const SectionResult& section = part.sections[1];
    const auto& contour = section.fit->contour;
    const auto measured = std::count_if(contour.begin(), contour.end(), [](const auto& p) { return p.measured; });
    EXPECT_LT(measured, static_cast<std::ptrdiff_t>(contour.size()));
    EXPECT_EQ(count_of(section_csv(section), "\n"), static_cast<std::size_t>(measured) + 1);
    const std::string json = result_json(part);
    EXPECT_NE(json.find("\"contour_points\": " + std::to_string(measured)), std::string::npos);
    EXPECT_EQ(count_of(json, "\"from_mm\""), 1U);
    EXPECT_NE(report_html(part).find("1 gap of"), std::string::npos);
    const std::string dmis = dmis_output(part);
    EXPECT_NE(dmis.find("FA(SECT_0)"), std::string::npos);
    EXPECT_EQ(dmis.find("FA(SECT_1)"), std::string::npos);
}

/// The lean of a section with a wide gap is that of the sections beside it: 15 um and more are taken off.
TEST(SectionGaps, WithAWideGapTheLeanComesFromTheOthers) {
    const auto part = judged_without(on_suction_side, judged);
    const auto two = judged_without([](const auto&, const auto&) { return true; }, judged);
    const SectionResult& section = part.sections[1];
    ASSERT_TRUE(section.has_contour()) << section.why;
    EXPECT_EQ(section.compensation.state, Compensation::State::final) << section.compensation.note;
    double largest = 0.0;
    for (std::size_t i = 0; i < section.deviation_mm.size(); ++i)
        if (section.deviation_mm[i]) largest = std::max(largest, std::abs(*section.deviation_mm[i]));
    EXPECT_LT(largest, 0.002);
    // It tells the others nothing: they are what two sections alone are.
    for (const std::size_t other : {0U, 2U}) {
        const SectionResult &with = part.sections[other], &alone = two.sections[other];
        ASSERT_EQ(with.fit->contour.size(), alone.fit->contour.size());
        for (std::size_t i = 0; i < with.fit->contour.size(); ++i)
            EXPECT_EQ(with.fit->contour[i].position_mm, alone.fit->contour[i].position_mm);
    }
}

/// No surface goes round the blade; what was measured of the sections tells the lean all the same.
TEST(SectionGaps, WithoutAnySectionAllRoundTheLeanComesFromWhatThereIs) {
    for (const Missing& missing : {Missing(on_suction_side), Missing(round_the_te)}) {
        const auto part = judged_without(missing, judged, {0, 1, 2});
        EXPECT_EQ(count_of(result_json(part), "none that go all round"), 3U);
        EXPECT_NE(report_html(part).find("none that go all round"), std::string::npos);
        for (const SectionResult& section : part.sections) {
            ASSERT_TRUE(section.has_contour()) << section.why;
            EXPECT_EQ(section.compensation.state, Compensation::State::final) << section.compensation.note;
            EXPECT_NE(section.compensation.note.find("none that go all round"), std::string::npos);
            EXPECT_TRUE(section.find("le_radius")->value);
            const auto& contour = section.fit->contour;
            std::size_t places = 0, sure = 0;
            double largest = 0.0;
            for (std::size_t i = 0; i < contour.size(); ++i) {
                if (!section.deviation_mm[i]) continue;
                const double off = std::abs(*section.deviation_mm[i]);
                ++places;
                sure += contour[i].u95_mm < 0.003 ? 1U : 0U;
                largest = std::max(largest, off);
                EXPECT_LT(off, std::max(contour[i].u95_mm, 0.003)) << i;
            }
            EXPECT_GT(static_cast<double>(sure), 0.7 * static_cast<double>(places));
            EXPECT_LT(largest, 0.005) << "15 um and more in the plane";
        }
    }
}

TEST(SectionGaps, BeyondTheSectionsAllRoundTheLeanComesFromThem) {
    const auto part = judged_without(round_the_te, judged, {2});
    const SectionResult& section = part.sections[2];
    EXPECT_EQ(section.compensation.state, Compensation::State::final) << section.compensation.note;
    EXPECT_NE(section.compensation.note.find("none that go all round"), std::string::npos);
    for (std::size_t i = 0; i < section.deviation_mm.size(); ++i) {
        const double off = std::abs(section.deviation_mm[i].value_or(0.0));
        EXPECT_LT(off, std::max(section.fit->contour[i].u95_mm, 0.003)) << i;
    }
    for (const std::size_t other : {0U, 1U})
        EXPECT_TRUE(part.sections[other].compensation.note.empty());
}

TEST(SectionGaps, ASingleSectionStaysInThePlane) {
    const auto part = judged_without(on_suction_side, judged, {0, 1, 2}, 0.0, true, 1);
    ASSERT_EQ(part.sections.size(), 1U);
    EXPECT_EQ(part.sections[0].compensation.state, Compensation::State::flat);
    EXPECT_NE(part.sections[0].compensation.note.find("no other section"), std::string::npos);
}

TEST(SectionGaps, WithoutAnEdgeTheRestIsJudged) {
    const auto part = judged_without(round_the_te, judged);
    const SectionResult& section = part.sections[1];
    ASSERT_TRUE(section.has_contour()) << section.why;
    EXPECT_FALSE(section.all_round());
    EXPECT_NE(section.why_not_all_round().find("nothing was measured between"), std::string::npos);
    EXPECT_TRUE(section.nose_mm(fitting::Zone::le));
    EXPECT_FALSE(section.nose_mm(fitting::Zone::te));
    EXPECT_EQ(section.compensation.state, Compensation::State::final) << section.compensation.note;
    EXPECT_LT(section.compensation.change_mm, 0.05);
    EXPECT_EQ(section.find("profile_le")->decision, Decision::accept) << section.find("profile_le")->note;
    EXPECT_EQ(section.find("profile_suction")->decision, Decision::undecided);
    EXPECT_TRUE(section.find("profile_suction")->value);
    EXPECT_FALSE(section.find("profile_te")->value);
    EXPECT_TRUE(section.find("le_radius")->value) << section.find("le_radius")->note;
    for (const auto* name : {"te_radius", "chord"})
        EXPECT_FALSE(section.find(name)->value) << name;
    EXPECT_EQ(part.verdict(), Decision::undecided);
    const std::string json = result_json(part), page = report_html(part);
    EXPECT_EQ(count_of(json, "\"closed\": false"), 1U);
    EXPECT_EQ(count_of(json, "\"why\": \"nothing was measured between"), 1U);
    EXPECT_EQ(count_of(page, "Measured in part: nothing was measured between"), 1U);
    EXPECT_EQ(count_of(page, "<b>Leading edge</b>"), 3U);
    EXPECT_EQ(count_of(page, "<b>Trailing edge</b>"), 2U);
}

TEST(SectionGaps, OneSideAloneIsJudged) {
    const Missing but_suction = [](const RecordedPoint&, const Eigen::Vector2d& normal) { return normal.y() < 0.7; };
    for (const double thicken_mm : {0.0, 0.15}) {
        const auto part = judged_without(but_suction, judged, {0, 1, 2}, thicken_mm, false);
        for (const SectionResult& section : part.sections) {
            ASSERT_TRUE(section.has_contour()) << section.why;
            EXPECT_FALSE(section.all_round());
            const auto& suction = *section.find("profile_suction");
            ASSERT_TRUE(suction.value) << suction.note;
            EXPECT_NEAR(*suction.value, 2.0 * thicken_mm, 0.06) << suction.note;
            EXPECT_EQ(suction.decision, thicken_mm > 0.1 ? Decision::reject : Decision::undecided) << suction.note;
            for (const auto* name :
                 {"profile_le", "profile_pressure", "le_radius", "te_radius", "chord", "max_thickness"})
                EXPECT_FALSE(section.find(name)->value) << name;
        }
        EXPECT_EQ(part.verdict(), thicken_mm > 0.1 ? Decision::reject : Decision::undecided);
    }
}

}  // namespace
}  // namespace cmm::acquisition
