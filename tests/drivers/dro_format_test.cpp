// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/config.hpp"
#include "drivers/dro/line_format.hpp"
#include "drivers/dro/line_splitter.hpp"

namespace cmm::drivers::dro {
namespace {

using Kind = LineContent::Kind;
using Counts = std::array<std::int32_t, 3>;

DroSettings with(const std::string& format) {
    DroSettings settings;
    settings.format = format;
    return settings;
}

LineContent read(const DroSettings& settings, std::string_view line) {
    const auto format = LineFormat::compile(settings);
    EXPECT_TRUE(format) << format.error().text();
    return format ? format->read(line) : LineContent{};
}

Counts point(const DroSettings& settings, std::string_view line) {
    const auto content = read(settings, line);
    EXPECT_EQ(content.kind, Kind::point) << line << ": " << content.why;
    return content.counts;
}

void expect_garbled(const DroSettings& settings, std::string_view line, std::string_view why) {
    const auto content = read(settings, line);
    EXPECT_EQ(content.kind, Kind::garbled) << line;
    EXPECT_NE(content.why.find(why), std::string::npos) << line << ": " << content.why;
}

// The eight formats of the generic interface that CMM programs offer: letters or none, decimals or integers, with and
// without a fourth axis.
TEST(DroFormat, TheEightGenericFormats) {
    const Counts expected{1000000, -2000000, 3000005};
    for (const bool fourth : {false, true}) {
        const std::string more = fourth ? ",W{w}" : "", plain_more = fourth ? ",{w}" : "";
        const std::string w = fourth ? ",W90.000" : "", plain_w = fourth ? ",90.000" : "";
        EXPECT_EQ(point(with("X{x},Y{y},Z{z}" + more), "X100.0000,Y-200.0000,Z300.0005" + w), expected);
        EXPECT_EQ(point(with("{x},{y},{z}" + plain_more), "100.0000,-200.0000,300.0005" + plain_w), expected);
        auto integers = with("X{x},Y{y},Z{z}" + more);
        integers.integers = true;
        integers.count = 0.001;
        const Counts counts{100000, -200000, 300000};
        EXPECT_EQ(point(integers, "X100000,Y-200000,Z300000" + std::string(fourth ? ",W90" : "")), counts);
        integers.format = "{x},{y},{z}" + plain_more;
        EXPECT_EQ(point(integers, "100000,-200000,300000" + std::string(fourth ? ",90" : "")), counts);
    }
}

TEST(DroFormat, BlanksSignsAndOrder) {
    EXPECT_EQ(point(with("X = {x} Y = {y} Z = {z} R"), "  X = +  12.5  Y=- 0.0001\tZ =  .5 R  "),
              (Counts{125000, -1, 5000}));
    EXPECT_EQ(point(with("{z};{x};{y}"), "3.;1.0;2.0"), (Counts{10000, 20000, 30000}));
    auto comma = with("X{x} Y{y} Z{z}");
    comma.decimal_comma = true;
    EXPECT_EQ(point(comma, "X1,5 Y-2,25 Z0,0001"), (Counts{15000, -22500, 1}));
}

TEST(DroFormat, InchesKeepTheirCounts) {
    const auto table = core::ConfigTable::parse("unit = \"inch\"\n", "machine.toml");
    ASSERT_TRUE(table);
    const auto settings = read_dro_settings(*table);
    ASSERT_TRUE(table->finish()) << table->finish().error().text();
    EXPECT_DOUBLE_EQ(settings.lsb_mm(), 0.000254);
    const auto counts = point(settings, "X1.00000,Y-0.50000,Z0.00001");
    EXPECT_EQ(counts, (Counts{100000, -50000, 1}));
    EXPECT_DOUBLE_EQ(counts[0] * settings.lsb_mm(), 25.4);
}

TEST(DroFormat, NothingIsGuessed) {
    const auto letters = with("X{x},Y{y},Z{z}");
    expect_garbled(letters, "X1.0,Y2.0", "',' expected");
    expect_garbled(letters, "X1.0,Y2.0,Z3.0,", "something follows");
    expect_garbled(letters, "x1.0,Y2.0,Z3.0", "'X' expected");
    expect_garbled(letters, "X1.0,Y,Z3.0", "no number for y");
    expect_garbled(letters, "X1.0,Y2.0.0,Z3.0", "',' expected");
    expect_garbled(letters, "X1.0,Y2e3,Z3.0", "decimal point");
    expect_garbled(letters, "X1.0,Ynan,Z3.0", "no number for y");
    // A readout that sends counts, read as millimetres, would be wrong by a thousand.
    expect_garbled(letters, "X1000,Y2000,Z3000", "no number for x with a decimal point");
    expect_garbled(letters, "X300000.0,Y0.0,Z0.0", "within reach");
    expect_garbled(letters, "X1.0,Y\xb2.0,Z3.0", "speed, parity and data bits");
    auto integers = letters;
    integers.integers = true;
    expect_garbled(integers, "X1.0,Y2,Z3", "',' expected");
    expect_garbled(integers, "X99999999999,Y2,Z3", "within reach");
    auto places = letters;
    places.decimals = 3;
    EXPECT_EQ(point(places, "X1.000,Y2.000,Z3.000"), (Counts{10000, 20000, 30000}));
    expect_garbled(places, "X1.000,Y2.000,Z3.00", "no number for z with 3 decimals");
}

TEST(DroFormat, TagsAndTheEnd) {
    auto tagged = with("{tag},{x},{y},{z}");
    tagged.point_tags = "PQ";
    tagged.end = "END";
    EXPECT_EQ(point(tagged, "Q,1.0,2.0,3.0"), (Counts{10000, 20000, 30000}));
    EXPECT_EQ(read(tagged, "L,1.0,2.0,3.0").kind, Kind::no_point);
    EXPECT_EQ(read(tagged, " END ").kind, Kind::end);
    expect_garbled(tagged, "P,1.0,2.0", "',' expected");
    expect_garbled(tagged, "", "tag is missing");
}

TEST(DroFormat, AFormatThatCannotBeReadIsRefused) {
    const auto refused = [](const DroSettings& settings) {
        const auto format = LineFormat::compile(settings);
        return format ? std::string() : format.error().message;
    };
    EXPECT_NE(refused(with("X{x},Y{y}")).find("{z} must be there once, not 0 times"), std::string::npos);
    EXPECT_NE(refused(with("{x},{y},{z},{x}")).find("not 2 times"), std::string::npos);
    EXPECT_NE(refused(with("{x}{y},{z}")).find("needs something between"), std::string::npos);
    EXPECT_NE(refused(with("{x},{y},{q}")).find("{q} is no field"), std::string::npos);
    EXPECT_NE(refused(with("{x},{y},{z")).find("'}' is missing"), std::string::npos);
    EXPECT_NE(refused(with("{tag} {x},{y},{z}")).find("point_tags"), std::string::npos);
    EXPECT_NE(refused(with("")).find("{x} must be there"), std::string::npos);
}

TEST(DroFormat, TheMachineFileIsChecked) {
    const auto error = [](const char* text) {
        const auto table = core::ConfigTable::parse(text, "machine.toml");
        EXPECT_TRUE(table);
        read_dro_settings(*table);
        const auto done = table->finish();
        return done ? std::string() : done.error().message;
    };
    EXPECT_EQ(error("format = \"{x},{y},{z}\"\nnumbers = \"integer\"\ncount = 0.001\n"), "");
    EXPECT_NE(error("numbers = \"integer\"\n").find("count is missing"), std::string::npos);
    EXPECT_NE(error("request_every_ms = 100\n").find("needs a request"), std::string::npos);
    EXPECT_NE(error("formt = \"{x},{y},{z}\"\n").find("did you mean \"format\""), std::string::npos);
    EXPECT_NE(error("format = \"{x},{y}\"\n").find("machine.toml:1"), std::string::npos);
}

std::vector<std::string> lines_of(const std::vector<std::string>& pieces, bool whole = true) {
    LineSplitter splitter;
    splitter.restart(whole);
    std::vector<LineSplitter::Line> lines;
    for (const auto& piece : pieces) {
        std::vector<std::uint8_t> bytes(piece.begin(), piece.end());
        splitter.feed(bytes, lines);
    }
    std::vector<std::string> texts;
    for (const auto& line : lines)
        texts.push_back((line.whole ? "" : "?") + line.text);
    return texts;
}

TEST(DroLines, EveryLineEndAndEveryCut) {
    const std::vector<std::string> expected{"a", "b", "c", "d"};
    EXPECT_EQ(lines_of({"a\rb\nc\r\nd\r\n"}), expected);
    EXPECT_EQ(lines_of({"a\r\n\r\n\nb\rc\r", "\nd\n"}), expected);
    EXPECT_EQ(lines_of({"a", "\r", "b\n", "c\r", "\n", "", "d", "\n", "unfinished"}), expected);
}

TEST(DroLines, ATailAndALineWithoutEndAreMarked) {
    EXPECT_EQ(lines_of({"34,5.6\r\n1.2,3.4\n"}, false), (std::vector<std::string>{"?34,5.6", "1.2,3.4"}));
    const auto cut = lines_of({std::string(1000, 'x') + "\nshort\n"});
    ASSERT_EQ(cut.size(), 2U);
    EXPECT_EQ(cut[0], "?" + std::string(LineSplitter::longest, 'x'));
    EXPECT_EQ(cut[1], "short");
}

}  // namespace
}  // namespace cmm::drivers::dro
