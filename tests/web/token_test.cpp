// SPDX-License-Identifier: Apache-2.0
#include "web/server/token.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/acquisition/temp_folder.hpp"

namespace cmm::web {
namespace {

TEST(Token, NewOnesDifferAndAreLong) {
    const auto a = new_token(), b = new_token();
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->size(), 32U);
    EXPECT_NE(*a, *b);
}

TEST(Token, ComparesAllOfIt) {
    EXPECT_TRUE(same_token("0123456789abcdef", "0123456789abcdef"));
    for (const char* other : {"", "0", "0123456789abcdeF", "1123456789abcdef", "0123456789abcdef0", "0123456789abcde"})
        EXPECT_FALSE(same_token("0123456789abcdef", other)) << other;
    EXPECT_FALSE(same_token("", ""));
    EXPECT_FALSE(same_token("", "x"));
}

TEST(Token, AFileIsItsOwnersAlone) {
    const acquisition::TempFolder folder;
    const std::string file = folder.write("token", "0123456789-Abcdef_\n");
    ASSERT_EQ(::chmod(file.c_str(), 0600), 0);
    EXPECT_EQ(read_token_file(file).value(), "0123456789-Abcdef_");
    for (const unsigned mode : {0640U, 0604U, 0660U}) {
        ASSERT_EQ(::chmod(file.c_str(), mode), 0);
        const auto refused = read_token_file(file);
        ASSERT_FALSE(refused) << mode;
        EXPECT_NE(refused.error().message.find("chmod 600"), std::string::npos);
    }
    EXPECT_EQ(read_token_file(folder.path("none")).error().code, core::ErrorCode::input_missing);
    EXPECT_EQ(read_token_file(folder.path("")).error().code, core::ErrorCode::input_missing);
}

TEST(Token, AnotherFormIsRefused) {
    const acquisition::TempFolder folder;
    for (const std::string& text :
         {std::string("short"), std::string(129, 'a'), std::string("0123456789 abcdef"),
          std::string("0123456789abcdef\nsecond"), std::string(), std::string("0123456789abcdef\xc3\xa9")}) {
        const std::string file = folder.write("token", text);
        ASSERT_EQ(::chmod(file.c_str(), 0600), 0);
        EXPECT_FALSE(read_token_file(file)) << text;
    }
}

}  // namespace
}  // namespace cmm::web
