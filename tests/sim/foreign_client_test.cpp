// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

#include "tests/sim/served_bar.hpp"
#include "tests/support/serial_wire.hpp"

/// Clients that share no code with us drive the simulated machine over the real wire. Each is skipped where it is not
/// installed.
namespace cmm::sim::test {
namespace {

constexpr int not_installed = 77;

struct Outcome {
    int code = -1;
    std::string output;
};

Outcome run(const std::string& command) {
    Outcome outcome;
    std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
    if (pipe == nullptr) return outcome;
    std::array<char, 4096> buffer;
    while (const std::size_t got = std::fread(buffer.data(), 1, buffer.size(), pipe))
        outcome.output.append(buffer.data(), got);
    const int status = ::pclose(pipe);
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return outcome;
}

bool have(const std::string& tool) {
    return run("command -v " + tool).code == 0;
}

TEST(ForeignClient, MbpollReadsIdentityAndStatus) {
    if (!have("mbpoll")) GTEST_SKIP() << "mbpoll is not installed (apt-get install mbpoll)";
    const ServedBar bar;
    const std::string base = "mbpoll -m tcp -a 1 -0 -1 -p " + std::to_string(bar.port());
    const Outcome identity = run(base + " -r 0 -c 46 -t 4:hex 127.0.0.1");
    ASSERT_EQ(identity.code, 0) << identity.output;
    EXPECT_NE(identity.output.find("[0]: \t0x434D"), std::string::npos) << identity.output;
    EXPECT_NE(identity.output.find("[1]: \t0x4D31"), std::string::npos) << identity.output;
    EXPECT_NE(identity.output.find("[44]: \t0x004D"), std::string::npos) << "boot id 77: " << identity.output;
    const Outcome state = run(base + " -r 64 -c 1 -t 4 127.0.0.1");
    EXPECT_NE(state.output.find("[64]: \t0"), std::string::npos) << state.output;
    const Outcome fifo = run(base + " -r 400 -c 125 -t 4 127.0.0.1");
    EXPECT_NE(fifo.output.find("[407]: \t0"), std::string::npos) << "no samples yet: " << fifo.output;
    const Outcome input = run(base + " -r 0 -c 1 -t 3:hex 127.0.0.1");
    EXPECT_NE(input.output.find("0x434D"), std::string::npos) << "FC 4 reads the same: " << input.output;
}

TEST(ForeignClient, MbpollStopsTheMachine) {
    if (!have("mbpoll")) GTEST_SKIP() << "mbpoll is not installed (apt-get install mbpoll)";
    const ServedBar bar;
    const std::string base = "mbpoll -m tcp -a 1 -0 -1 -p " + std::to_string(bar.port());
    EXPECT_EQ(run(base + " -r 200 -t 4 127.0.0.1 2").code, 0);
    const Outcome state = run(base + " -r 64 -c 1 -t 4 127.0.0.1");
    EXPECT_NE(state.output.find("[64]: \t8"), std::string::npos) << state.output;
}

TEST(ForeignClient, PymodbusScansFromTheDocumentAlone) {
    // Debian keeps its packages with the system interpreter.
    const std::string python = have("/usr/bin/python3") ? "/usr/bin/python3" : "python3";
    const ServedBar bar;
    const Outcome outcome =
        run(python + " tests/peers/foreign_scan.py " + std::to_string(bar.port()) + " " + std::to_string(circle_mm));
    if (outcome.code == not_installed || outcome.code == 127) GTEST_SKIP() << "apt-get install python3-pymodbus";
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("ok    nobody owns it"), std::string::npos) << outcome.output;
}

/// The simulator on one end of a serial wire, for clients on the other.
SerialLine line_at(const std::string& port) {
    SerialLine line;
    line.path = port;
    return line;
}

TEST(ForeignClient, MbpollReadsAndStopsOverRtu) {
    if (!have("mbpoll")) GTEST_SKIP() << "mbpoll is not installed (apt-get install mbpoll)";
    const cmm::test::SerialWire wire;
    const ServedBar bar(line_at(wire.device()));
    const std::string base = "mbpoll -m rtu -a 1 -b 115200 -P none -0 -1 ";
    const Outcome identity = run(base + "-r 0 -c 46 -t 4:hex " + wire.host());
    ASSERT_EQ(identity.code, 0) << identity.output;
    EXPECT_NE(identity.output.find("[1]: \t0x4D31"), std::string::npos) << identity.output;
    const Outcome fifo = run(base + "-r 400 -c 125 -t 4 " + wire.host());
    EXPECT_NE(fifo.output.find("[407]: \t0"), std::string::npos) << "no samples yet: " << fifo.output;
    EXPECT_EQ(run(base + "-r 200 -t 4 " + wire.host() + " 2").code, 0);
    const Outcome state = run(base + "-r 64 -c 1 -t 4 " + wire.host());
    EXPECT_NE(state.output.find("[64]: \t8"), std::string::npos) << state.output;
    EXPECT_NE(run("mbpoll -m rtu -a 2 -b 115200 -P none -0 -1 -o 0.2 -r 0 -c 1 " + wire.host()).code, 0)
        << "unit 2 is somebody else";
}

TEST(ForeignClient, PymodbusScansOverRtu) {
    const std::string python = have("/usr/bin/python3") ? "/usr/bin/python3" : "python3";
    const cmm::test::SerialWire wire;
    const ServedBar bar(line_at(wire.device()));
    const Outcome outcome =
        run(python + " tests/peers/foreign_scan.py " + wire.host() + " " + std::to_string(circle_mm));
    if (outcome.code == not_installed || outcome.code == 127) GTEST_SKIP() << "apt-get install python3-pymodbus";
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("ok    nobody owns it"), std::string::npos) << outcome.output;
}

TEST(ForeignClient, PythonScansOverTheLineProtocolFromTheDocumentAlone) {
    if (!have("python3")) GTEST_SKIP() << "python3 is not installed";
    const cmm::test::SerialWire wire;
    const ServedBar bar(line_at(wire.device()), ServedBar::Speaks::line);
    const Outcome outcome = run("python3 tests/peers/line_scan.py " + wire.host() + " " + std::to_string(circle_mm));
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("ok    nobody owns it"), std::string::npos) << outcome.output;
}

TEST(ForeignClient, JsmodbusReadsInAPipeline) {
    if (!have("node")) GTEST_SKIP() << "node is not installed";
    const ServedBar bar;
    const Outcome outcome = run("node tests/peers/foreign_read.mjs " + std::to_string(bar.port()));
    if (outcome.code == not_installed) GTEST_SKIP() << "npm install jsmodbus, in the folder of the tests or above";
    EXPECT_EQ(outcome.code, 0) << outcome.output;
}

}  // namespace
}  // namespace cmm::sim::test
