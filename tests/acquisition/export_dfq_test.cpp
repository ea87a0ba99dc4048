// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>

#include "acquisition/exports.hpp"
#include "core/text.hpp"
#include "tests/acquisition/judged_part.hpp"

namespace cmm::acquisition {
namespace {

/// What a reader of AQDEF makes of a file: K field and number of the characteristic (0: of the part) to text.
using Fields = std::map<std::pair<std::string, int>, std::string>;

Fields read_back(const std::string& text) {
    Fields fields;
    std::size_t at = text.starts_with("\xef\xbb\xbf") ? 3 : 0;
    while (at < text.size()) {
        const auto end = text.find("\r\n", at);
        EXPECT_NE(end, std::string::npos) << "every line ends";
        if (end == std::string::npos) break;
        const std::string line = text.substr(at, end - at);
        at = end + 2;
        const auto space = line.find(' ');
        const std::string key = line.substr(0, space);
        EXPECT_TRUE(key.size() >= 5 && key[0] == 'K') << line;
        const int number = key.size() > 6 && key[5] == '/' ? std::stoi(key.substr(6)) : 0;
        const bool first = fields.emplace(std::pair(key.substr(0, 5), number), line.substr(space + 1)).second;
        EXPECT_TRUE(first) << line << " twice";
    }
    return fields;
}

TEST(Dfq, IsReadBackAsItWas) {
    auto part = part_of({section_at(0, 0.0), section_at(1, 0.2), open_section(2)});
    const auto angle = stagger_of("a method\r\nof two lines", 0.6);
    part.sections[0].characteristics.push_back(angle);
    const auto fields = read_back(dfq_text(part));
    const auto text = [&](const std::string& key, int number) {
        const auto found = fields.find({key, number});
        return found == fields.end() ? std::string("(none)") : found->second;
    };
    EXPECT_EQ(text("K1001", 0), part.part_name);
    int number = 0;
    for (const auto& section : part.sections)
        for (const auto& one : section.characteristics) {
            ++number;
            const auto same = [&](const std::string& key, const std::optional<double>& value) {
                EXPECT_EQ(text(key, number), value ? core::fixed(*value, 6) : "(none)") << key << " of " << one.name;
            };
            EXPECT_EQ(text("K2002", number), one.name + " z " + core::fixed(section.z_mm, 3));
            EXPECT_EQ(text("K2142", number), to_string(one.unit));
            same("K0001", one.value);
            EXPECT_EQ(text("K0002", number), one.value ? "0" : "255") << "a value that is none is marked";
            same("K2101", one.nominal);
            same("K2111", one.upper);
            same("K2110", one.name.starts_with("profile_") ? 0.0 : one.lower);
            EXPECT_EQ(text("K0014", number), part.part_serial);
            EXPECT_EQ(text("K0004", number), "04.03.2025/09:12:31");
        }
    EXPECT_EQ(text("K0100", 0), std::to_string(number));
}

TEST(Dfq, CharacteristicsOfThePartFollowThoseOfSections) {
    auto part = part_of({section_at(0, 0.0), section_at(1, 0.2)});
    const int before = std::stoi(read_back(dfq_text(part)).at({"K0100", 0}));
    add_of_part(part);
    const auto fields = read_back(dfq_text(part));
    EXPECT_EQ(fields.at({"K0100", 0}), std::to_string(before + 3));
    EXPECT_EQ(fields.at({"K2002", before + 1}), "lean_x");
    EXPECT_EQ(fields.at({"K0001", before + 1}), "0.012300");
    EXPECT_EQ(fields.at({"K2110", before + 1}), "-0.050000");
    EXPECT_EQ(fields.at({"K2002", before + 2}), "relative_twist z 20.000");
    EXPECT_EQ(fields.at({"K2142", before + 2}), "rad");
    EXPECT_EQ(fields.at({"K2002", before + 3}), "bow_y z 10.000");
    EXPECT_EQ(fields.at({"K0002", before + 3}), "255");
    EXPECT_EQ(fields.count({"K0001", before + 3}), 0U);
}

TEST(Dfq, OtherLettersAreMarkedAsUtf8) {
    auto part = part_of({section_at(0, 0.0)});
    EXPECT_FALSE(dfq_text(part).starts_with("\xef\xbb\xbf"));
    part.part_name = "Läufer";
    const auto text = dfq_text(part);
    EXPECT_TRUE(text.starts_with("\xef\xbb\xbf"));
    EXPECT_EQ(read_back(text).at({"K1001", 0}), part.part_name);
}

}  // namespace
}  // namespace cmm::acquisition
