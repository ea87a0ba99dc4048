// SPDX-License-Identifier: Apache-2.0
// One job over every transport: the same part, plan and seed give the same files to the last byte.
#include <gtest/gtest.h>

#include <fstream>

#include "simulated_machine.hpp"
#include "tests/support/outputs.hpp"

namespace cmm::test {
namespace {

struct Transport {
    std::string name;
    std::string scheme;
    std::string options;
};

std::string text_of(const std::string& path) {
    std::ifstream in(path);
    return std::string(std::istreambuf_iterator<char>(in), {});
}

/// Scans the demo part on the machine; everything goes to `out`.
void scan_on(const std::string& machine, const TemporaryFolder& out) {
    const auto scan = run(
        {cmmlive(), "scan", "--machine", machine, "--part", "config/parts/demo.toml", "--out", out.path(), "--json"},
        std::chrono::seconds(250));
    EXPECT_EQ(scan.exit_code, 0) << scan.out << scan.err;
}

/// The same on a simulator that listens on `listen`.
void scan_demo(const std::string& listen, const TemporaryFolder& out) {
    SimulatedMachine machine("config/parts/demo.toml", out, {"--speed", "0", "--seed", "3"}, listen);
    ASSERT_FALSE(machine.url().empty()) << machine.process().wait(std::chrono::seconds(1)).err;
    scan_on(machine.url(), out);
    machine.end();
}

class Transports : public testing::TestWithParam<Transport> {};

TEST_P(Transports, TheDemoPartGivesTheSameFilesAsOverTcp) {
    const TemporaryFolder over_tcp;
    const TemporaryFolder over_line;
    scan_demo("modbus+tcp://127.0.0.1:0", over_tcp);
    if (GetParam().scheme == "replay") {
        scan_on("replay:" + (over_tcp / "run.cmmrun") + GetParam().options, over_line);
    } else {
        scan_demo(GetParam().scheme + "://" + over_line.path() + "/port?pty=yes" + GetParam().options, over_line);
    }
    for (const char* name : {"sections.csv", "section-0.csv", "section-7.csv", "rejected.csv", "points.csv"}) {
        EXPECT_FALSE(text_of(over_tcp / name).empty()) << name;
        EXPECT_EQ(text_of(over_tcp / name), text_of(over_line / name)) << name;
    }
}

INSTANTIATE_TEST_SUITE_P(Serial, Transports,
                         testing::Values(Transport{"ModbusRtu", "modbus+rtu", "&baud=115200&parity=none&unit=5"},
                                         Transport{"Line", "line+serial", "&baud=115200"},
                                         Transport{"Replay", "replay", ""},
                                         Transport{"ReplayPaced", "replay", "?speed=50"}),
                         [](const auto& transport) { return transport.param.name; });

}  // namespace
}  // namespace cmm::test
