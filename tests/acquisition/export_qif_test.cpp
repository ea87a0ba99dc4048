// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "acquisition/exports.hpp"
#include "core/text.hpp"
#include "tests/acquisition/count_of.hpp"
#include "tests/acquisition/judged_part.hpp"
#include "tests/acquisition/temp_folder.hpp"
#include "tests/acquisition/test_blade.hpp"

namespace cmm::acquisition {
namespace {

const std::string schema = real_data("qif30-xsd/QIFApplications/QIFDocument.xsd");

/// What libxml2's xmllint says, which is none of ours; empty: the document is valid.
std::string complaints(const std::string& xml) {
    const TempFolder folder;
    const auto file = folder.write("part.qif", xml), said = folder.path("said");
    const std::string command = "xmllint --nonet --noout --schema " + schema + " " + file + " >" + said + " 2>&1";
    return std::system(command.c_str()) == 0 ? "" : core::read_file(said).value();
}

struct QifTest : ::testing::Test {
    void SetUp() override {
        if (!std::filesystem::exists(schema)) GTEST_SKIP() << "no schemas of QIF 3.0 here";
        if (std::system("xmllint --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "no xmllint here";
    }
};

TEST_F(QifTest, DocumentsAreValid) {
    EXPECT_EQ(complaints(qif_xml(part_of({section_at(0, 0.0), section_at(1, 0.2)}))), "");
    EXPECT_EQ(complaints(qif_xml(part_of({section_at(0, 0.0, false), open_section(1)}))), "");
    EXPECT_EQ(complaints(qif_xml(part_of({}))), "");
    auto of_points = part_of({section_at(0, 0.0)});
    of_points.started_utc.clear();
    EXPECT_EQ(complaints(qif_xml(of_points)), "") << "point files do not say when they were measured";
    auto asked = section_at(0, 0.0);
    for (const Unit unit : {Unit::mm, Unit::rad, Unit::mm2, Unit::per_mm, Unit::share, Unit::count})
        for (const bool upper : {true, false})
            for (const bool lower : {true, false}) {
                Characteristic one;
                one.name = "asked <for>";
                one.method = "some method & its source";
                one.value = 1.25;
                one.u95 = 0.002;
                one.unit = unit;
                one.nominal = 1.2;
                if (upper) one.upper = 1.3;
                if (lower) one.lower = 1.1;
                asked.characteristics.push_back(one);
            }
    EXPECT_EQ(complaints(qif_xml(part_of({asked}))), "");
    auto several = part_of({section_at(0, 0.0), section_at(1, 0.2)});
    add_of_part(several);
    EXPECT_EQ(complaints(qif_xml(several)), "");
    EXPECT_NE(complaints("<QIFDocument/>"), "") << "what is not valid is found";
}

TEST(Qif, EveryCharacteristicHasItsValueUncertaintyAndDecision) {
    const auto part = part_of({section_at(0, 0.0), section_at(1, 0.2), open_section(2)});
    const auto xml = qif_xml(part);
    std::size_t all = 0, valued = 0, rejected = 0, unknown = 0;
    for (const auto& section : part.sections)
        for (const auto& one : section.characteristics) {
            ++all;
            valued += one.value ? 1 : 0;
            rejected += one.decision == Decision::reject ? 1 : 0;
            unknown += one.decision == Decision::not_evaluable ? 1 : 0;
        }
    ASSERT_GT(rejected, 0U);
    ASSERT_GT(unknown, 0U);
    EXPECT_EQ(count_of(xml, "CharacteristicMeasurement id="), all);
    EXPECT_EQ(count_of(xml, "<Value combinedUncertainty="), valued);
    EXPECT_EQ(count_of(xml, ">FAIL</CharacteristicStatusEnum>"), rejected);
    EXPECT_EQ(count_of(xml, ">UNDEFINED</CharacteristicStatusEnum>"), unknown);
    const auto alike = qif_xml(part_of({part.sections[0], part.sections[1]}));
    EXPECT_EQ(count_of(alike, "CharacteristicDefinition id="), part.sections[0].characteristics.size())
        << "what is asked of all sections is defined once";
    const auto& chord = *part.sections[0].find("chord");
    EXPECT_NE(xml.find("<Value combinedUncertainty=\"" + core::fixed(0.5 * *chord.u95, 6) + "\">" +
                       core::fixed(*chord.value, 6) + "</Value>"),
              std::string::npos);
    EXPECT_NE(xml.find("<InspectionStatusEnum>FAIL<"), std::string::npos);
    EXPECT_EQ(xml, qif_xml(part));
}

TEST(Qif, DocumentsHaveAnIdOfTheirContent) {
    const auto id_of = [](const PartResult& part) {
        const auto xml = qif_xml(part);
        const auto from = xml.find("<QPId>") + 6;
        return xml.substr(from, xml.find("</QPId>") - from);
    };
    const auto of_points = [](double shift) {
        auto part = part_of({section_at(0, shift)});
        part.run_id.clear();
        part.part_serial.clear();
        part.started_utc.clear();
        return part;
    };
    const auto id = id_of(of_points(0.0));
    EXPECT_EQ(id.size(), 36U);
    EXPECT_EQ(id, id_of(of_points(0.0)));
    EXPECT_NE(id, id_of(of_points(0.2))) << "point files have no run id";
    auto same_numbers = part_of({section_at(0, 0.0)});
    const auto first = id_of(same_numbers);
    same_numbers.run_id += "b";
    EXPECT_NE(first, id_of(same_numbers));
}

TEST(Qif, CurvaturesHaveAUnitOfTheirOwn) {
    auto section = section_at(0, 0.0);
    const auto plain = qif_xml(part_of({section}));
    EXPECT_EQ(count_of(plain, "UserDefinedUnit"), 0U);
    Characteristic dent;
    dent.name = "least_curvature_suction_2";
    dent.method = "CURVATURE";
    dent.unit = Unit::per_mm;
    dent.value = -0.0012345678;
    dent.u95 = 0.0004;
    section.characteristics.push_back(dent);
    EXPECT_EQ(qif_xml(part_of({section})), plain) << "QIF has no place for one without limits";
    auto& judged = section.characteristics.back();
    judged.nominal = 0.01;
    judged.lower = 0.0;
    judged.decision = Decision::reject;
    const auto xml = qif_xml(part_of({section}));
    EXPECT_EQ(count_of(xml, "<UserDefinedUnitCharacteristicMeasurement"), 1U);
    for (const char* said :
         {"<WhatIsMeasured>curvature</WhatIsMeasured><UnitName>1/mm</UnitName>",
          "<TargetValue unitName=\"1/mm\">0.010000000</TargetValue><MinValue unitName=\"1/mm\">0.000000000</MinValue>",
          "<Value combinedUncertainty=\"0.000200000\" unitName=\"1/mm\">-0.001234568</Value>"})
        EXPECT_NE(xml.find(said), std::string::npos) << said;
}

TEST(Qif, CharacteristicsOfThePartAreThere) {
    auto part = part_of({section_at(0, 0.0), section_at(1, 0.2)});
    const auto without = qif_xml(part);
    add_of_part(part);
    const auto xml = qif_xml(part);
    EXPECT_EQ(count_of(xml, "CharacteristicMeasurement id="), count_of(without, "CharacteristicMeasurement id=") + 3);
    EXPECT_NE(xml.find("<Name>lean_x</Name>"), std::string::npos) << "of no section";
    EXPECT_NE(xml.find("<Name>relative_twist z 20.000</Name>"), std::string::npos);
    EXPECT_NE(xml.find("<Value combinedUncertainty=\"0.002000\">0.012300</Value>"), std::string::npos);
    EXPECT_EQ(count_of(xml, ">UNDEFINED</CharacteristicStatusEnum>"), 1U);
    EXPECT_EQ(count_of(xml, "<UserDefinedAngularCharacteristicMeasurement"), 1U);
}

}  // namespace
}  // namespace cmm::acquisition
