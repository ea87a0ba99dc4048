// SPDX-License-Identifier: Apache-2.0
#include "core/toml_text.hpp"

#include <gtest/gtest.h>

#include <string>

#include "core/config.hpp"

namespace cmm::core {
namespace {

TEST(TomlText, StringsAndCommentsMaySayAnything) {
    for (const char* text : {"", "a = 1", "# é\nname = \"Schaufel Ø\" # ü", "a = 'ü' \nb = \"\"\"ä\n\"ö\" \\\" ü\"\"\"",
                             "a = '''é\n'ü'''' # ö\nb = 1", "\xEF\xBB\xBF# a mark of the byte order\na = 1", "#"})
        EXPECT_FALSE(first_foreign_letter(text)) << text;
}

TEST(TomlText, ElsewhereAForeignLetterIsFound) {
    const struct {
        const char* text;
        std::size_t line, column;
    } cases[] = {{"größe = 1", 1, 3},         {"a = 1\nb = 2é", 2, 6}, {"a = \"open\nb = é", 2, 5},
                 {"a = \"x\\\"y\" é", 1, 12}, {"a = '\\' é", 1, 9},    {"a = ''' ' '' ''' é", 1, 18},
                 {"# é\n\xC2\xA0 = 1", 2, 1}};
    for (const auto& one : cases) {
        const auto found = first_foreign_letter(one.text);
        ASSERT_TRUE(found) << one.text;
        EXPECT_EQ(found->line, one.line) << one.text;
        EXPECT_EQ(found->column, one.column) << one.text;
    }
}

TEST(TomlText, AConfigurationWithOneIsRefusedWithItsPlace) {
    const auto table = ConfigTable::parse("a = 1\n\xD0\x9E", "part.toml");
    ASSERT_FALSE(table);
    EXPECT_EQ(table.error().code, ErrorCode::config_syntax);
    EXPECT_NE(table.error().message.find("part.toml:2:1"), std::string::npos) << table.error().message;
}

}  // namespace
}  // namespace cmm::core
