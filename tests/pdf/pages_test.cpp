// SPDX-License-Identifier: Apache-2.0
#include "pdf/pages.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "acquisition/exports.hpp"
#include "core/text.hpp"
#include "tests/acquisition/judged_part.hpp"
#include "tests/support/process.hpp"

namespace cmm {
namespace {

/// What Poppler reads from it, which is none of ours.
std::string text_of(const std::string& pdf, const test::TemporaryFolder& folder) {
    const std::string file = folder / "pages.pdf";
    std::ofstream(file, std::ios::binary) << pdf;
    const auto read = test::run({"pdftotext", "-layout", file, "-"});
    EXPECT_EQ(read.exit_code, 0) << read.err;
    EXPECT_EQ(read.err, "") << "nothing to complain about";
    return read.out;
}

std::size_t pages_of(const std::string& text) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\f'));
}

class PdfPages : public ::testing::Test {
  protected:
    void SetUp() override {
        if (test::run({"pdftotext", "-v"}).exit_code != 0) GTEST_SKIP() << "no pdftotext here (poppler-utils)";
    }
    test::TemporaryFolder folder_;
};

TEST_F(PdfPages, ATableGoesOnWithItsHeadOnEveryPage) {
    auto pages = pdf::Pages::make({"long", "foot of long", "2026-03-01T10:00:00Z"});
    ASSERT_TRUE(pages) << pages.error().message;
    pages->title("Long table", "Done", pdf::Ink::plain);
    const std::vector<pdf::Column> columns{{"Number", 1.0, true}, {"Words", 3.0, false}};
    std::vector<std::vector<pdf::Cell>> rows;
    for (int k = 0; k < 200; ++k)
        rows.push_back({{std::to_string(k)}, {"line \u00b1 " + std::to_string(k)}});
    pages->table(columns, rows);
    const auto bytes = pages->finish();
    ASSERT_TRUE(bytes);
    const std::string text = text_of(*bytes, folder_);
    const std::size_t count = pages_of(text);
    EXPECT_GT(count, 2U);
    std::size_t heads = 0, feet = 0;
    for (auto at = text.find("Number"); at != std::string::npos; at = text.find("Number", at + 1))
        ++heads;
    for (auto at = text.find("foot of long"); at != std::string::npos; at = text.find("foot of long", at + 1))
        ++feet;
    EXPECT_EQ(heads, count);
    EXPECT_EQ(feet, count);
    for (int k = 0; k < 200; ++k)
        EXPECT_NE(text.find("line \u00b1 " + std::to_string(k) + "\n"), std::string::npos) << k;
}

TEST_F(PdfPages, WhatIsNoSvgIsRefused) {
    auto pages = pdf::Pages::make({"broken", "", ""});
    ASSERT_TRUE(pages);
    pages->pictures(std::vector<pdf::Picture>{{"a", "<html>"}, {"b", "<svg xmlns=\"http://www.w3.org/2000/svg\"/>"}},
                    2);
    const auto bytes = pages->finish();
    ASSERT_FALSE(bytes);
    EXPECT_NE(bytes.error().message.find("no SVG"), std::string::npos) << bytes.error().message;
}

TEST_F(PdfPages, TheReportHasAllThatTheOtherOneHas) {
    using namespace acquisition;
    const PartResult part = part_of({section_at(0, 0.0), section_at(1, 0.2), open_section(2)});
    const auto bytes = report_pdf(part);
    ASSERT_TRUE(bytes) << bytes.error().message;
    const std::string text = text_of(*bytes, folder_);
    const auto* worst = part.sections[1].find("profile_pressure");
    ASSERT_TRUE(worst && worst->value);
    for (const std::string& said :
         {std::string("rotor <1> & \"co\""), std::string("Reject"), std::string("S-7"), std::string("run-9"),
          std::string("Why it is rejected"), std::string("gap of 3.2 mm"), core::fixed(*worst->value, 4),
          std::string("Section 1, z = 20.000 mm: reject"), std::string("3-D: the contour"),
          std::string("Leading edge: r"), std::string("Deviations over the blade"), std::string("Not evaluable: ")})
        EXPECT_NE(text.find(said), std::string::npos) << said;
    EXPECT_EQ(*bytes, *report_pdf(part)) << "the same part, the same bytes";
}

}  // namespace
}  // namespace cmm
