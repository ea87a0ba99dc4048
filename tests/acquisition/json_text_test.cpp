// SPDX-License-Identifier: Apache-2.0
#include "acquisition/json_text.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>

namespace cmm::acquisition {
namespace {

using nlohmann::json;

constexpr auto replacement = "\xEF\xBF\xBD";

TEST(JsonText, QuotesAndEscapes) {
    EXPECT_EQ(json_string(""), "\"\"");
    EXPECT_EQ(json_string("a\"b\\c"), R"("a\"b\\c")");
    EXPECT_EQ(json_string("line\n\ttab"), R"("line\u000a\u0009tab")");
    std::string every;
    for (int c = 0; c < 0x80; ++c)
        every += static_cast<char>(c);
    EXPECT_EQ(json::parse(json_string(every)).get<std::string>(), every);
}

TEST(JsonText, LeavesUtf8AsItIs) {
    // The ends of the ranges of RFC 3629, section 4.
    for (const std::string text :
         {"\xC2\x80", "\xDF\xBF", "\xE0\xA0\x80", "\xED\x9F\xBF", "\xEE\x80\x80", "\xEF\xBF\xBF", "\xF0\x90\x80\x80",
          "\xF4\x8F\xBF\xBF", "Schaufel f\xC3\xBCr 3 \xC2\xB5m"}) {
        EXPECT_EQ(json_string(text), '"' + text + '"');
        EXPECT_EQ(json::parse(json_string(text)).get<std::string>(), text);
    }
}

TEST(JsonText, ReplacesWhatIsNotUtf8) {
    // Alone, overlong, surrogates, beyond U+10FFFF, cut off: whatever it is, a strict reader accepts the text.
    for (const std::string text :
         {"\x80", "\xFF", "\xC0\xAF", "\xC1\xBF", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xF0\x8F\xBF\xBF",
          "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xE2\x82", "\xF0\x9F"}) {
        const auto read = json::parse(json_string(text)).get<std::string>();
        EXPECT_EQ(read.substr(0, 3), replacement);
        EXPECT_EQ(read.size() % 3, 0U);
    }
    EXPECT_EQ(json::parse(json_string("a\xC3(b")).get<std::string>(), std::string("a") + replacement + "(b");
}

TEST(JsonText, FieldsMakeAnObject) {
    const std::optional<double> nothing;
    const auto text = JsonFields()
                          .add("name", "a \"b\"")
                          .add("z_mm", 40.00004, 4)
                          .add("big", std::numeric_limits<std::uint64_t>::max())
                          .add("least", std::numeric_limits<std::int64_t>::min())
                          .add("yes", true)
                          .add("no", false)
                          .add("u95_mm", std::optional<double>(0.0012345), 6)
                          .add("limit_mm", nothing, 6)
                          .raw("inner", "{\"k\":1}")
                          .text();
    EXPECT_EQ(text, R"("name":"a \"b\"","z_mm":40.0000,"big":18446744073709551615,"least":-9223372036854775808,)"
                    R"("yes":true,"no":false,"u95_mm":0.001234,"limit_mm":null,"inner":{"k":1})");
    EXPECT_EQ(json::parse("{" + text + "}").size(), 9U);
    EXPECT_EQ(JsonFields().text(), "");
}

TEST(JsonText, NumbersThatJsonHasNotAreNull) {
    for (const double value : {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                               std::numeric_limits<double>::quiet_NaN()}) {
        EXPECT_EQ(JsonFields().add("v", value, 3).text(), "\"v\":null");
        EXPECT_EQ(JsonFields().add("v", std::optional<double>(value), 3).text(), "\"v\":null");
    }
    for (const double value : {1e300, -1e300, 5e-324}) {
        EXPECT_TRUE(json::accept("{" + JsonFields().add("v", value, 3).text() + "}"));
    }
    EXPECT_EQ(JsonFields().add("v", -0.00001, 4).text(), "\"v\":0.0000");
}

}  // namespace
}  // namespace cmm::acquisition
