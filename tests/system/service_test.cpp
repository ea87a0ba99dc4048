// SPDX-License-Identifier: Apache-2.0
// The systemd unit of the cell, as systemd itself judges it, and the service as a user without any rights.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "tests/support/process.hpp"

namespace cmm::test {
namespace {

std::string unit_text() {
    std::ifstream in(CMMLIVE_UNIT);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// The unit with the program under test in the place of the installed one.
std::string unit_in(const TemporaryFolder& folder) {
    std::string text = unit_text();
    const std::string begin = "ExecStart=";
    const auto at = text.find(begin) + begin.size();
    text.replace(at, text.find(' ', at) - at, cmmlive());
    const std::string file = folder / "cmmlive-cell.service";
    std::ofstream(file) << text;
    return file;
}

TEST(Service, SystemdFindsNothingWrongWithTheUnit) {
    if (run({"sh", "-c", "command -v systemd-analyze"}).exit_code != 0) GTEST_SKIP() << "apt-get install systemd";
    const TemporaryFolder folder;
    const std::string unit = unit_in(folder);
    const auto verified = run({"systemd-analyze", "verify", "--man=no", unit});
    EXPECT_EQ(verified.exit_code, 0) << verified.err;
    EXPECT_EQ(verified.err, "");
    // 10 is a service that may do everything; up to 2 systemd says "OK".
    const auto exposed = run({"systemd-analyze", "security", "--offline=true", "--threshold=20", "--no-pager", unit});
    if (exposed.err.find("unrecognized option") != std::string::npos) GTEST_SKIP() << "an older systemd";
    EXPECT_EQ(exposed.exit_code, 0) << exposed.out << exposed.err;
}

TEST(Service, NoRightOfTheUnitIsWider) {
    const std::string text = unit_text();
    for (const char* line : {"\nDynamicUser=yes\n", "\nNoNewPrivileges=yes\n", "\nProtectSystem=strict\n",
                             "\nCapabilityBoundingSet=\n", "\nStateDirectory=cmmlive\n", "\nKillSignal=SIGTERM\n"})
        EXPECT_NE(text.find(line), std::string::npos) << line;
    EXPECT_EQ(text.find('@' + std::string("CMAKE")), std::string::npos) << "everything is filled in";
}

TEST(Service, NeedsNoRightsOfItsUser) {
    if (::geteuid() != 0) GTEST_SKIP() << "only root can become nobody";
    const std::vector<std::string> nobody{"setpriv",        "--reuid=65534",  "--regid=65534",
                                          "--clear-groups", "--no-new-privs", "--bounding-set=-all"};
    const auto as_nobody = [&](std::vector<std::string> command) {
        command.insert(command.begin(), nobody.begin(), nobody.end());
        return command;
    };
    if (run(as_nobody({cmmlive(), "--version"})).exit_code != 0) GTEST_SKIP() << "nobody cannot reach the program here";
    const TemporaryFolder folder;
    std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
    std::filesystem::create_directory(folder / "parts");
    std::filesystem::copy_file("tests/system/parts/fault-job.toml", folder / "parts/1.toml");
    std::filesystem::create_directory(folder / "state");
    ASSERT_EQ(::chown((folder / "state").c_str(), 65534, 65534), 0);
    Process cell(as_nobody({cmmlive(), "cell", "--machine", "modbus+tcp://127.0.0.1:1", "--parts", folder / "parts",
                            "--runs", folder / "state/runs", "--plc", "modbus+tcp://127.0.0.1:0"}),
                 folder / "cell");
    ASSERT_TRUE(wait_for([&] { return cell.out().find("plc: modbus+tcp://127.0.0.1:") != std::string::npos; }))
        << cell.err();
    struct stat about {};
    ASSERT_EQ(::stat((folder / "state/runs").c_str(), &about), 0);
    EXPECT_EQ(about.st_uid, 65534U);
    cell.signal(SIGTERM);
    EXPECT_EQ(cell.wait(std::chrono::seconds(10)).exit_code, 0) << cell.err();
}

}  // namespace
}  // namespace cmm::test
