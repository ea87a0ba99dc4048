// SPDX-License-Identifier: Apache-2.0
// A scan captured on the wire, as tshark's dissector of Modbus/TCP sees it.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>

#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

bool installed(const std::string& program) {
    return run({"sh", "-c", "command -v " + program + " >/dev/null"}).exit_code == 0;
}

std::string port_of(const std::string& url) {
    const auto from = url.rfind(':') + 1;
    return url.substr(from, url.find('?') - from);
}

std::ptrdiff_t lines_of(const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
}

TEST(Dissector, FindsNoMalformedFrameInACapturedScan) {
    if (!installed("tshark") || !installed("dumpcap")) GTEST_SKIP() << "tshark is not installed";
    const TemporaryFolder folder;
    const SimulatedMachine machine("tests/system/parts/fault-job.toml", folder, {"--speed", "20"});
    const std::string port = port_of(machine.url()), captured = folder / "scan.pcapng";
    Process capture({"dumpcap", "-q", "-B", "64", "-i", "lo", "-f", "tcp port " + port, "-w", captured},
                    folder / "dumpcap");
    wait_for([&] { return capture.err().find("File: ") != std::string::npos || !capture.running(); });
    if (!capture.running() && capture.err().find("permission") != std::string::npos)
        GTEST_SKIP() << "this user may not capture: " << capture.err();
    ASSERT_TRUE(capture.running()) << capture.err();
    const auto scan = run(scan_command(machine, "tests/system/parts/fault-job.toml", folder / "out", false),
                          std::chrono::seconds(60));
    EXPECT_LE(scan.exit_code, 2) << scan.err;
    capture.signal(SIGINT);
    capture.wait(std::chrono::seconds(20));

    const auto dissect = [&](const std::string& filter) {
        return run({"tshark", "-r", captured, "-d", "tcp.port==" + port + ",mbtcp", "-Y", filter, "-T", "fields", "-e",
                    "frame.number", "-e", "_ws.col.Info"});
    };
    const auto frames = dissect("modbus");
    ASSERT_EQ(frames.exit_code, 0) << frames.err;
    EXPECT_GT(lines_of(frames.out), 100) << frames.err;
    const auto malformed = dissect("_ws.malformed || (mbtcp && _ws.expert.severity == error)");
    ASSERT_EQ(malformed.exit_code, 0) << malformed.err;
    EXPECT_EQ(malformed.out, "");
}

}  // namespace
}  // namespace cmm::test
