// SPDX-License-Identifier: Apache-2.0
#include "web/server/target.hpp"

#include <gtest/gtest.h>

namespace cmm::web {
namespace {

using Words = std::vector<std::string>;

TEST(Target, IsTakenApartAndDecoded) {
    const auto target = parse_target("/api/run/a%20b/points?after=17&x=%e5%8f%b6");
    ASSERT_TRUE(target);
    EXPECT_EQ(target->path, (Words{"api", "run", "a b", "points"}));
    EXPECT_EQ(target->number("after"), 17U);
    EXPECT_EQ(target->query.at("x"), "\xe5\x8f\xb6");
    EXPECT_FALSE(target->number("x"));
    EXPECT_FALSE(target->number("absent"));
    EXPECT_TRUE(parse_target("/")->path.empty());
    EXPECT_TRUE(parse_target("/?a=1")->path.empty());
    EXPECT_EQ(parse_target("/?a=1")->number("a"), 1U);
}

TEST(Target, NumbersAreWholeAndFit) {
    const auto of = [](const std::string& text) { return parse_target("/?n=" + text)->number("n"); };
    EXPECT_EQ(of("18446744073709551615"), 18446744073709551615U);
    for (const char* bad : {"18446744073709551616", "-1", "1x", "", "1.0", "%201"})
        EXPECT_FALSE(of(bad)) << bad;
}

TEST(Target, WhatLeadsOutOfTheFolderIsRefused) {
    for (const char* bad : {"",        "api",       "http://a/",
                            "*",       "/..",       "/../etc/passwd",
                            "/a/../b", "/%2e%2e/x", "/a/%2e%2e%2fetc",
                            "/a%2fb",  "/a%5cb",    "/.",
                            "//",      "/a//b",     "/a/",
                            "/a%00b",  "/a%0ab",    "/a%7f",
                            "/%",      "/%4",       "/%zz",
                            "/%-1",    "/?a=1&a=2", "/?=1",
                            "/?&",     "/a?b=%00"})
        EXPECT_FALSE(parse_target(bad)) << bad;
    EXPECT_FALSE(parse_target("/" + std::string(1024, 'a')));
    EXPECT_TRUE(parse_target("/" + std::string(1023, 'a')));
}

}  // namespace
}  // namespace cmm::web
