// SPDX-License-Identifier: Apache-2.0
#include "acquisition/characteristic_table.hpp"

#include <gtest/gtest.h>

#include "acquisition/section_figures.hpp"
#include "core/units.hpp"
#include "judged_part.hpp"

namespace cmm::acquisition {
namespace {

Characteristic radius_in_a_window() {
    Characteristic c;
    c.name = "le_radius_arc_100";
    c.method = "least squares circle";
    c.note = "arc of 100 deg, rms 0.4 um";
    c.value = 0.4871;
    c.u95 = 0.0021;
    c.nominal = 0.5;
    c.lower = 0.4;
    c.upper = 0.6;
    c.decision = Decision::accept;
    return c;
}

TEST(CharacteristicTable, SaysOverWhichArcARadiusWasFitted) {
    auto section = section_at(0, 0.0);
    section.characteristics.push_back(radius_in_a_window());
    const auto part = part_of({section});
    const auto rows = asked_rows(part);
    ASSERT_EQ(rows.size(), 1U) << "what every section has is in the table of results";
    EXPECT_EQ(rows[0].deviation, "-0.0129");
    EXPECT_EQ(rows[0].method, "least squares circle; arc of 100 deg, rms 0.4 um");
    EXPECT_NE(characteristic_table(part).find("least squares circle; arc of 100 deg"), std::string::npos);
}

TEST(CharacteristicTable, SaysWhyThereIsNoValueAndAnglesInDegrees) {
    auto refused = radius_in_a_window();
    refused.value = refused.u95 = std::nullopt;
    refused.note = "an arc of 40 deg is too short";
    refused.decision = Decision::not_evaluable;
    Characteristic twist;
    twist.name = "relative_twist";
    twist.method = "best fit";
    twist.unit = Unit::rad;
    twist.value = core::rad_from_deg(0.25);
    auto section = section_at(0, 0.0);
    section.characteristics.push_back(refused);
    auto part = part_of({section});
    part.characteristics.push_back({twist, std::nullopt});
    const auto rows = asked_rows(part);
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[0].section, "part");
    EXPECT_EQ(rows[0].value + rows[0].unit, "0.2500\u00b0");
    EXPECT_EQ(rows[0].method, "best fit") << "with nothing to add";
    EXPECT_EQ(rows[1].section, "0");
    EXPECT_TRUE(rows[1].value.empty() && rows[1].deviation.empty());
    EXPECT_EQ(rows[1].method, "an arc of 40 deg is too short");
}

TEST(SectionFigures, EdgesSayRadiusAndArc) {
    const auto text = radius_text(section_at(0, 0.0), fitting::Zone::le);
    EXPECT_EQ(text.substr(0, 2), "r ");
    EXPECT_NE(text.find(" mm, arc of "), std::string::npos) << text;
}

}  // namespace
}  // namespace cmm::acquisition
