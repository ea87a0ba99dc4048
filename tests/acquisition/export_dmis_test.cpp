// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acquisition/exports.hpp"
#include "core/units.hpp"
#include "tests/acquisition/judged_part.hpp"

namespace cmm::acquisition {
namespace {

/// A statement as a reader of DMIS sees it: "FA(SECT_0)=FEAT/GCURVE,CART,..." as FA(SECT_0), FEAT, fields.
struct Statement {
    std::string label, word;
    std::vector<std::string> fields;

    double number(std::size_t k) const { return std::stod(fields.at(k)); }
};

class DmisReader {
  public:
    explicit DmisReader(const std::string& text) {
        std::string whole;
        std::size_t at = 0;
        bool in_remark = false;
        while (at < text.size()) {
            const auto end = text.find("\r\n", at);
            EXPECT_NE(end, std::string::npos) << "every line ends";
            if (end == std::string::npos) return;
            std::string line = text.substr(at, end - at);
            at = end + 2;
            if (line.starts_with("$$")) {
                EXPECT_LE(line.size(), 80U) << line;
                if (in_remark)
                    remarks_.back() += " " + line.substr(3);
                else
                    remarks_.push_back(line.substr(3));
                in_remark = true;
                continue;
            }
            in_remark = false;
            EXPECT_LE(line.size(), 81U) << line;
            const bool goes_on = line.ends_with('$');
            if (goes_on) line.pop_back();
            whole += line;
            if (goes_on) continue;
            add(whole);
            whole.clear();
        }
        EXPECT_TRUE(whole.empty()) << "a statement without end";
    }
    const std::vector<Statement>& statements() const { return statements_; }
    const Statement* find(const std::string& label) const {
        for (const auto& one : statements_)
            if (one.label == label) return &one;
        return nullptr;
    }
    bool remarks(const std::string& text) const {
        for (const auto& remark : remarks_)
            if (remark.find(text) != std::string::npos) return true;
        return false;
    }

  private:
    void add(const std::string& text) {
        Statement one;
        auto rest = text;
        if (const auto equals = text.find('='); equals != std::string::npos && equals < text.find('\'')) {
            one.label = text.substr(0, equals);
            rest = text.substr(equals + 1);
        }
        const auto slash = rest.find('/');
        one.word = rest.substr(0, slash);
        bool quoted = false;
        if (slash != std::string::npos) one.fields.emplace_back();
        for (std::size_t i = slash + 1; slash != std::string::npos && i < rest.size(); ++i) {
            if (rest[i] == '\'') quoted = !quoted;
            if (rest[i] == ',' && !quoted)
                one.fields.emplace_back();
            else
                one.fields.back() += rest[i];
        }
        statements_.push_back(one);
    }

    std::vector<Statement> statements_;
    std::vector<std::string> remarks_;
};

/// The decisions are those of the rule; the file has the numbers of result.json.
TEST(Dmis, IsReadBackWithTheNumbersOfTheResult) {
    auto part = part_of({section_at(0, 0.0), section_at(1, 0.2), open_section(2)});
    auto angle = stagger_of(
        "it's, a method of 'many' words, long enough, to be written, on more than one line, of 80 letters", 0.501);
    angle.decision = Decision::undecided;
    part.sections[0].characteristics.push_back(angle);
    part.sections[0].characteristics.push_back(reported("area, 1", "Green", 0.123, 0.001, {}));
    for (auto& one : part.sections[0].characteristics)
        if (one.name == "le_radius") {
            one.nominal = 0.39;
            one.lower = 0.3;
            one.upper = 0.5;
            one.decision = Decision::accept;
        }
    add_of_part(part);
    const DmisReader file(dmis_output(part));
    EXPECT_EQ(file.statements().front().word, "FILNAM");
    EXPECT_EQ(file.statements().back().word, "ENDFIL");
    EXPECT_EQ(file.find("PN(PART)")->fields[0], "'rotor <1> & \"co\"'");
    EXPECT_EQ(file.find("PS(PART)")->fields[0], "'S-7'");
    EXPECT_EQ(file.find("DATE")->word, "2025");  // DATE=2025/03/04

    const auto result = nlohmann::json::parse(result_json(part));
    std::size_t judged = 0, in = 0;
    for (const auto& section : result.at("sections")) {
        const std::string number = std::to_string(section.at("index").get<int>());
        for (const auto& one : section.at("characteristics")) {
            std::string label = one.at("name").get<std::string>() + "_" + number;
            for (char& c : label)
                c = std::isalnum(static_cast<unsigned char>(c)) != 0
                        ? static_cast<char>(std::toupper(static_cast<unsigned char>(c)))
                        : '_';
            const auto* actual = file.find("TA(" + label + ")");
            const auto* asked = file.find("T(" + label + ")");
            const bool has_limits = !one.at("lower").is_null() || !one.at("upper").is_null();
            const bool expected = has_limits && !one.at("value").is_null();
            ASSERT_EQ(actual != nullptr, expected) << label;
            ASSERT_EQ(asked != nullptr, expected) << label;
            if (!expected) continue;
            ++judged;
            const bool accepted = one.at("decision") == "accept";
            in += accepted ? 1 : 0;
            EXPECT_EQ(actual->fields.back(), accepted ? "INTOL" : "OUTOL") << label;
            const double value = one.at("value").get<double>(),
                         scale = one.at("unit") == "rad" ? 180.0 / 3.14159265358979 : 1.0;
            if (actual->fields[0] == "PROFL") {
                EXPECT_NEAR(2.0 * std::max(-actual->number(1), actual->number(2)), value, 2e-6) << label;
                EXPECT_NEAR(asked->number(2) - asked->number(1), one.at("upper").get<double>(), 2e-6);
                continue;
            }
            const double nominal = one.at("nominal").is_null() ? 0.0 : one.at("nominal").get<double>();
            const std::size_t first = actual->fields[0] == "RAD" ? 1 : 2;
            EXPECT_NEAR(actual->number(first), scale * (value - nominal), 2e-6) << label;
            EXPECT_NEAR(asked->number(first + 1), scale * (one.at("upper").get<double>() - nominal), 2e-6) << label;
            EXPECT_NEAR(asked->number(first), scale * (one.at("lower").get<double>() - nominal), 2e-6) << label;
        }
    }
    EXPECT_GE(judged, 10U);
    EXPECT_GE(in, 5U);
    EXPECT_LT(in, judged);
    EXPECT_TRUE(file.remarks("stagger: undecided, 28.647890, U95 0.057296"));
    EXPECT_TRUE(file.remarks("area, 1: reported, 0.123000"));
    EXPECT_TRUE(file.remarks("section 2 z 30.000: "));
    EXPECT_NEAR(file.find("TA(LEAN_X)")->number(2), 0.0123, 1e-9);
    EXPECT_EQ(file.find("TA(BOW_Y_0)"), nullptr) << "not evaluable";
}

TEST(Dmis, FeaturesAreTheSectionsAndTheirEdges) {
    auto part = part_of({section_at(0, 0.0), open_section(1)});
    // Where the points of an outline are dense says nothing about where it lies.
    auto& outline = part.sections[0].nominal_contour;
    for (std::size_t i = 0; i + 1 < outline.size(); ++i)
        if (outline[i].x() > 0.0) outline.erase(outline.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    const DmisReader file(dmis_output(part));
    const auto* edge = file.find("FA(LE_0)");
    ASSERT_NE(edge, nullptr);
    EXPECT_EQ(edge->fields[0], "CIRCLE");
    EXPECT_EQ(edge->fields[1], "OUTER");
    EXPECT_NEAR(edge->number(3), part.sections[0].fit->le.centre_mm.x(), 1e-6);
    EXPECT_NEAR(edge->number(5), part.sections[0].z_mm, 1e-6);
    EXPECT_NEAR(edge->number(9), 2.0 * part.sections[0].fit->le.radius_mm, 1e-6);
    const auto *nominal = file.find("F(SECT_0)"), *actual = file.find("FA(SECT_0)");
    ASSERT_NE(nominal, nullptr);
    ASSERT_NE(actual, nullptr);
    EXPECT_EQ(actual->fields[0], "GCURVE");
    EXPECT_NEAR(actual->number(2), nominal->number(2), 0.002);
    EXPECT_NEAR(actual->number(3), nominal->number(3), 0.002);
    EXPECT_EQ(file.find("FA(SECT_1)"), nullptr) << "an open section is none";
}

}  // namespace
}  // namespace cmm::acquisition
