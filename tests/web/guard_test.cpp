// SPDX-License-Identifier: Apache-2.0
#include "web/server/guard.hpp"

#include <gtest/gtest.h>

namespace cmm::web {
namespace {

const std::string token = "0123456789abcdef";

Request asking(const std::string& method, const std::string& host = "127.0.0.1:8686") {
    Request request;
    request.method = method;
    request.target = "/api/status";
    request.host = host;
    request.content_type = "application/json";
    return request;
}
int code(const std::optional<Response>& refused) {
    return refused ? refused->status : 200;
}

TEST(Guard, KnowsItsOwnNames) {
    const Guard guard(token, false, {"cell7"});
    for (const char* host :
         {"127.0.0.1", "127.0.0.1:8686", "localhost:1", "[::1]:8686", "[::1]", "192.168.0.7:80", "cell7", "cell7:8686"})
        EXPECT_EQ(code(guard.refuse(asking("GET", host))), 200) << host;
    // What a page of someone else sends whose name was turned to this address.
    for (const char* host : {"", "evil.example", "evil.example:8686", "cell7.evil.example", "localhost.evil.example",
                             "127.0.0.1.evil.example", "[::1", "127.0.0.1:", "127.0.0.1:x", "127.0.0.1:123456",
                             "user@127.0.0.1", "2130706433", "[::1]x"})
        EXPECT_EQ(code(guard.refuse(asking("GET", host))), 403) << host;
}

TEST(Guard, OnlyItsOwnOrigin) {
    const Guard guard(token, false, {});
    auto request = asking("POST");
    for (const char* origin : {"", "http://127.0.0.1:8686", "https://127.0.0.1:8686"}) {
        request.origin = origin;
        EXPECT_EQ(code(guard.refuse(request)), 200) << origin;
    }
    for (const char* origin : {"null", "http://127.0.0.1:8687", "http://127.0.0.1", "http://evil.example", "file://",
                               "http://127.0.0.1:8686.evil.example"}) {
        request.origin = origin;
        EXPECT_EQ(code(guard.refuse(request)), 403) << origin;
    }
}

TEST(Guard, OtherMethodsAndFormsAreRefused) {
    const Guard guard(token, false, {});
    for (const char* method : {"PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "get", ""})
        EXPECT_EQ(code(guard.refuse(asking(method))), 405) << method;
    auto form = asking("POST");
    form.content_type = "application/x-www-form-urlencoded";  // what a page of another origin may send unasked
    EXPECT_EQ(code(guard.refuse(form)), 415);
}

TEST(Guard, ChangesNeedTheToken) {
    const Guard guard(token, false, {});
    EXPECT_EQ(code(guard.refuse_api(asking("GET"))), 200);
    auto change = asking("POST");
    EXPECT_EQ(code(guard.refuse_api(change)), 401);
    change.token = "0123456789abcdeX";
    EXPECT_EQ(code(guard.refuse_api(change)), 401);
    change.token = token;
    EXPECT_EQ(code(guard.refuse_api(change)), 200);
}

TEST(Guard, OnAnotherAddressReadingNeedsItToo) {
    const Guard guard(token, true, {});
    EXPECT_EQ(code(guard.refuse_api(asking("GET"))), 401);
    auto shown = asking("GET");
    shown.token = token;
    EXPECT_EQ(code(guard.refuse_api(shown)), 200);
}

}  // namespace
}  // namespace cmm::web
