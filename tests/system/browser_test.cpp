// SPDX-License-Identifier: Apache-2.0
// `cmmlive demo` before a person who has a browser, and before none. The browser is a script that keeps what it was
// given; the terminal is that of script(1).
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/process.hpp"

namespace cmm::test {
namespace {

class Browser : public testing::Test {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists("/usr/bin/script")) GTEST_SKIP() << "script is not installed";
        std::filesystem::create_directory(folder_ / "bin");
        std::ofstream(folder_ / "bin/xdg-open") << "#!/bin/sh\necho \"$@\" > " << folder_ / "arguments"
                                                << "\ncp \"$1\" " << folder_ / "shown"
                                                << "\n";
        std::filesystem::permissions(folder_ / "bin/xdg-open", std::filesystem::perms::owner_all);
    }
    /// `environment`: NAME=value or -uNAME words for env(1).
    Finished demo(bool terminal, const std::vector<std::string>& environment, const std::string& more = "--speed 60") {
        std::vector<std::string> command{"/usr/bin/env", "-u", "CI", "PATH=" + (folder_ / "bin") + ":/usr/bin:/bin",
                                         "DISPLAY=:77"};
        command.insert(command.end(), environment.begin(), environment.end());
        const std::string job = cmmlive() + " demo --out " + (folder_ / "out") + " " + more;
        if (terminal)
            command.insert(command.end(), {"/usr/bin/script", "-qec", job, "/dev/null"});
        else
            command.insert(command.end(), {"/bin/sh", "-c", job});
        return run(command);
    }
    std::string kept(const std::string& name) const {
        std::ifstream in(folder_ / name);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    bool opened() const { return std::filesystem::exists(folder_ / "arguments"); }

    TemporaryFolder folder_;
};

TEST_F(Browser, IsOpenedForAPersonBeforeATerminal) {
    const auto ran = demo(true, {});
    EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
    ASSERT_TRUE(opened()) << ran.out;
    EXPECT_NE(kept("shown").find("url=http://127.0.0.1:"), std::string::npos) << kept("shown");
    EXPECT_NE(kept("shown").find("#token="), std::string::npos);
    EXPECT_EQ(kept("arguments"), (folder_ / "out/open.html") + "\n") << "others can read the arguments of programs";
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out/open.html")) << "it holds the token";
}

TEST_F(Browser, ShowsThePageThatWasAskedFor) {
    const auto ran = demo(true, {}, "--speed 0 --serve 127.0.0.1:0");
    EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
    EXPECT_NE(ran.out.find("page: http"), std::string::npos) << ran.out;
    EXPECT_TRUE(wait_for([&] { return opened(); }));
}

TEST_F(Browser, IsLeftAloneWhereNobodyAsked) {
    for (const auto& [terminal, environment, more] :
         {std::tuple<bool, std::vector<std::string>, const char*>{true, {}, "--speed 60 --no-browser"},
          {true, {"CI=true"}, "--speed 60"},
          {true, {"DISPLAY="}, "--speed 60"},
          {true, {"PATH=/nowhere"}, "--speed 60"},
          {true, {}, "--speed 60 --json"},
          {true, {}, "--speed 0"},
          {false, {}, "--speed 60"}}) {
        const auto ran = demo(terminal, environment, more);
        EXPECT_EQ(ran.exit_code, 0) << more << ran.out << ran.err;
        EXPECT_FALSE(opened()) << terminal << more << (environment.empty() ? "" : environment[0]);
        EXPECT_EQ((ran.out + ran.err).find("page: http"), std::string::npos) << more;
    }
}

}  // namespace
}  // namespace cmm::test
