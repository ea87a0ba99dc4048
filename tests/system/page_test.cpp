// SPDX-License-Identifier: Apache-2.0
// The page's server as users start it: clients that share no code with it watch a job, stop it, and look at runs.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tests/support/outputs.hpp"
#include "tests/support/process.hpp"

namespace cmm::test {
namespace {

using nlohmann::json;

struct PageOutcome {
    int code = -1;
    std::string output;
};

PageOutcome shell(const std::string& command) {
    PageOutcome outcome;
    std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
    if (pipe == nullptr) return outcome;
    std::array<char, 4096> buffer{};
    while (const std::size_t got = std::fread(buffer.data(), 1, buffer.size(), pipe))
        outcome.output.append(buffer.data(), got);
    const int status = ::pclose(pipe);
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return outcome;
}

/// What the program printed behind "page: ".
struct Address {
    std::string base, port, token;
};
Address address_in(const std::string& text) {
    Address address;
    const auto at = text.find("http://"), mark = text.find("/#token=");
    if (at == std::string::npos || mark == std::string::npos) return address;
    address.base = text.substr(at, mark - at);
    address.port = address.base.substr(address.base.rfind(':') + 1);
    address.token = text.substr(mark + 8, 32);
    return address;
}

bool no_curl() {
    return shell("command -v curl").code != 0;
}

TEST(Page, AForeignClientHearsEveryEventOfAJob) {
    const TemporaryFolder folder;
    Process demo({cmmlive(), "demo", "--out", folder / "run", "--speed", "5", "--serve", "127.0.0.1:0", "--stay"},
                 folder / "log");
    ASSERT_TRUE(wait_for([&] { return demo.err().find("/#token=") != std::string::npos; })) << demo.err();
    const auto at = address_in(demo.err());
    const auto watched = shell("/usr/bin/python3 tests/peers/page_watch.py " + at.port + " 8");
    if (watched.code == 77) GTEST_SKIP() << watched.output;
    EXPECT_EQ(watched.code, 0) << watched.output;
    ASSERT_TRUE(wait_for([&] { return demo.err().find("the page stays") != std::string::npos; }));
    // What the page shows of the finished run is what the files say.
    if (!no_curl()) {
        const auto shown = json::parse(shell("curl -s " + at.base + "/api/run/run").output, nullptr, false);
        ASSERT_TRUE(shown.is_object());
        EXPECT_EQ(shown.at("result").at("sections"),
                  json::parse(shell("cat " + (folder / "run/result.json")).output).at("sections"));
    }
    demo.signal(SIGINT);
    EXPECT_EQ(demo.wait(std::chrono::seconds(20)).exit_code, 0);
    EXPECT_EQ(shell("ls " + (folder / "run")).output.find("-wal"), std::string::npos) << "settled though it was read";
}

TEST(Page, CurlStopsTheMachineWithTheTokenOnly) {
    if (no_curl()) GTEST_SKIP() << "curl is not installed";
    const TemporaryFolder folder;
    Process demo({cmmlive(), "demo", "--out", folder / "run", "--serve", "127.0.0.1:0"}, folder / "log");
    ASSERT_TRUE(wait_for([&] { return demo.err().find("/#token=") != std::string::npos; })) << demo.err();
    const auto at = address_in(demo.err());
    const std::string request =
        "curl -s -o /dev/null -w '%{http_code}' -X POST -d '{}' -H 'Content-Type: application/json' ";
    EXPECT_EQ(shell(request + at.base + "/api/stop").output, "401");
    EXPECT_TRUE(demo.running());
    EXPECT_EQ(shell(request + "-H 'Authorization: Bearer " + at.token + "' " + at.base + "/api/stop").output, "200");
    const auto ended = demo.wait(std::chrono::seconds(30));
    EXPECT_EQ(ended.exit_code, 4) << ended.err;
    EXPECT_NE(ended.err.find("stopped on request"), std::string::npos) << ended.err;
}

TEST(Page, ServeShowsAFolderOfRuns) {
    if (no_curl()) GTEST_SKIP() << "curl is not installed";
    const TemporaryFolder folder;
    ASSERT_EQ(run({cmmlive(), "demo", "--speed", "0", "--out", folder / "one"}).exit_code, 0);
    Process serve({cmmlive(), "serve", "--runs", folder.path(), "--listen", "127.0.0.1:0", "--json"}, folder / "log");
    ASSERT_TRUE(wait_for([&] { return serve.out().find("/#token=") != std::string::npos; })) << serve.err();
    const auto at = address_in(serve.out());
    const auto runs = json::parse(shell("curl -s " + at.base + "/api/runs").output).at("runs");
    ASSERT_EQ(runs.size(), 1U);
    EXPECT_EQ(runs[0].at("verdict"), "accept");
    serve.signal(SIGTERM);
    EXPECT_EQ(serve.wait(std::chrono::seconds(20)).exit_code, 0);

    EXPECT_EQ(run({cmmlive(), "serve", "--runs", folder / "none"}).exit_code, 3);
    const auto open = run({cmmlive(), "serve", "--runs", folder.path(), "--listen", "0.0.0.0:0"});
    EXPECT_EQ(open.exit_code, 3);
    EXPECT_NE(open.err.find("--token-file"), std::string::npos) << open.err;
}

}  // namespace
}  // namespace cmm::test
