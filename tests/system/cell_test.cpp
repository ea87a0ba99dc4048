// SPDX-License-Identifier: Apache-2.0
// The cell as a plant starts it: a PLC in Python measures parts on the simulated machine.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <nlohmann/json.hpp>

#include "tests/support/process.hpp"
#include "tests/system/simulated_machine.hpp"

namespace cmm::test {
namespace {

std::string text_of(const std::string& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

void replace(std::string& text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
}

/// Two sections: short runs.
constexpr const char* small_part = "tests/system/parts/fault-job.toml";
/// Eight sections: runs in whose middle something can happen.
constexpr const char* long_part = "config/parts/demo.toml";

class CellSystemTest : public ::testing::Test {
  protected:
    /// Program 1 is what lies on the machine, program 2 a blade 0.3 mm thicker, program 3 is broken.
    void prepare(const std::string& part, const std::string& speed, const std::string& faults = "") {
        if (run({"/usr/bin/python3", "-c", "import pymodbus"}).exit_code != 0)
            GTEST_SKIP() << "apt-get install python3-pymodbus";
        std::filesystem::create_directory(folder / "parts");
        std::string text = text_of(part);
        std::ofstream(folder / "parts/1-good.toml") << text;
        replace(text, "thickness_root_mm = 6.0", "thickness_root_mm = 6.3");
        replace(text, "thickness_tip_mm = 4.0", "thickness_tip_mm = 4.3");
        std::ofstream(folder / "parts/002.toml") << text;
        std::ofstream(folder / "parts/3 broken.toml") << "[part]\nname = 3\n";
        std::ofstream(folder / "parts/readme.txt") << "not a part\n";
        std::vector<std::string> more{"--speed", speed};
        if (!faults.empty()) more.insert(more.end(), {"--faults", faults});
        machine = std::make_unique<SimulatedMachine>(part, folder, more);
        ASSERT_FALSE(machine->url().empty());
    }
    void start(const std::vector<std::string>& more = {}) {
        std::vector<std::string> arguments{
            cmmlive(),        "cell",   "--machine",     machine->url(), "--parts",
            folder / "parts", "--runs", folder / "runs", "--plc",        "modbus+tcp://127.0.0.1:0",
            "--json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        cell = std::make_unique<Process>(arguments, folder / ("cell" + std::to_string(++starts)));
        ASSERT_TRUE(wait_for([&] { return cell->out().find('\n') != std::string::npos || !cell->running(); }));
        const auto printed = nlohmann::json::parse(cell->out(), nullptr, false);
        ASSERT_TRUE(printed.is_object()) << cell->err();
        const std::string url = printed.at("plc");
        port = url.substr(url.rfind(':') + 1);
        page = printed.at("page");
    }
    void plc(const std::string& script, const std::string& argument) const {
        const auto outcome =
            run({"/usr/bin/python3", "tests/peers/" + script, port, argument}, std::chrono::seconds(150));
        EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err << cell->err();
    }
    void end() {
        cell->signal(SIGTERM);
        EXPECT_EQ(cell->wait(std::chrono::seconds(20)).exit_code, 0) << cell->err();
    }
    nlohmann::json record() const { return nlohmann::json::parse(text_of(folder / "runs/cell.json"), nullptr, false); }

    TemporaryFolder folder;
    std::unique_ptr<SimulatedMachine> machine;
    std::unique_ptr<Process> cell;
    std::string port, page;
    int starts = 0;
};

TEST_F(CellSystemTest, TenPartsThroughTheHandshakeWithLostConnections) {
    prepare(small_part, "6");
    if (IsSkipped()) return;
    start({"--stop-when-rejected"});
    plc("cell_plc.py", "10");
    // Files are written behind the result; the service ends behind its files.
    end();
    std::vector<std::string> serials;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "runs"))
        if (entry.is_directory()) serials.push_back(entry.path().filename());
    std::sort(serials.begin(), serials.end());
    ASSERT_EQ(serials.size(), 10U);
    for (std::size_t i = 0; i < serials.size(); ++i) {
        const std::string serial = "PY-000" + std::to_string(i);
        EXPECT_TRUE(serials[i].ends_with("-" + serial)) << serials[i];
        const std::string path = folder / ("runs/" + serials[i]);
        const auto result = nlohmann::json::parse(text_of(path + "/result.json"), nullptr, false);
        ASSERT_TRUE(result.is_object()) << serials[i];
        EXPECT_EQ(result.at("verdict"), i % 3 == 2 ? "reject" : "accept");
        EXPECT_EQ(result.at("part").at("serial"), serial);
        // The run file alone knows which part it was.
        ASSERT_EQ(run({cmmlive(), "export", path, "--format", "json", "--out", folder / "again.json"}).exit_code, 0);
        EXPECT_EQ(nlohmann::json::parse(text_of(folder / "again.json")).at("part").at("serial"), serial);
    }
    EXPECT_EQ(record().at("phase"), "cleared");
}

TEST_F(CellSystemTest, WhateverStopsARunTheMachineRestsAndThePlcHearsWhy) {
    prepare(long_part, "5");
    if (IsSkipped()) return;
    start();
    plc("cell_faults.py", "stops");
    // The machine's own word.
    const auto asked = run({cmmlive(), "doctor", "--machine", machine->url(), "--json"});
    const auto state = nlohmann::json::parse(asked.out, nullptr, false);
    ASSERT_TRUE(state.is_object()) << asked.err;
    EXPECT_TRUE(state.at("machine").at("state") == "idle" || state.at("machine").at("state") == "stopped") << asked.out;
    plc("cell_faults.py", "refusals");
    end();
}

TEST_F(CellSystemTest, KilledAtAnyPointItLosesNothingAndDoublesNothing) {
    prepare(long_part, "20");
    if (IsSkipped()) return;
    start();
    plc("cell_faults.py", "begin");
    EXPECT_EQ(record().at("phase"), "measuring");
    cell->signal(SIGKILL);
    cell->wait(std::chrono::seconds(5));
    start();
    plc("cell_faults.py", "killed");
    plc("cell_faults.py", "standing");
    EXPECT_EQ(record().at("phase"), "done");
    cell->signal(SIGKILL);
    cell->wait(std::chrono::seconds(5));
    start();
    plc("cell_faults.py", "stands");
    end();
    EXPECT_EQ(record().at("phase"), "cleared");
    EXPECT_EQ(record().at("run"), 3);
}

TEST_F(CellSystemTest, ForeignEyesReadMetricsAndState) {
    prepare(small_part, "6");
    if (IsSkipped()) return;
    start({"--serve", "127.0.0.1:0", "--stop-when-rejected"});
    plc("cell_plc.py", "3");
    const auto outcome = run({"/usr/bin/python3", "tests/peers/cell_metrics.py", page.substr(0, page.find("/#"))});
    if (outcome.exit_code == 77) GTEST_SKIP() << outcome.out;
    EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
    end();
}

TEST_F(CellSystemTest, ABrokerIsToldAndWhenItIsGoneNothingWaits) {
    prepare(small_part, "6");
    if (IsSkipped()) return;
    if (run({"sh", "-c", "command -v /usr/sbin/mosquitto mosquitto_sub"}).exit_code != 0)
        GTEST_SKIP() << "apt-get install mosquitto mosquitto-clients";
    const std::string broker_port = run({"/usr/bin/python3", "-c",
                                         "import socket; s = socket.socket(); s.bind(('127.0.0.1', 0)); "
                                         "print(s.getsockname()[1], end='')"})
                                        .out;
    const auto start_broker = [&](const std::string& log) {
        auto broker =
            std::make_unique<Process>(std::vector<std::string>{"/usr/sbin/mosquitto", "-p", broker_port}, folder / log);
        EXPECT_TRUE(wait_for([&] { return broker->err().find("running") != std::string::npos; })) << broker->err();
        return broker;
    };
    /// So many messages, as "topic payload" lines.
    const auto hear = [&](const std::string& topic, const std::string& count) {
        return run({"mosquitto_sub", "-p", broker_port, "-t", topic, "-v", "-C", count, "-W", "20"}).out;
    };
    auto broker = start_broker("broker1");
    start({"--serve", "127.0.0.1:0", "--stop-when-rejected", "--mqtt",
           "mqtt://127.0.0.1:" + broker_port + "/hall/cell7"});
    Process listener({"mosquitto_sub", "-p", broker_port, "-t", "hall/cell7/decision", "-v"}, folder / "decisions");
    ASSERT_NE(hear("hall/cell7/online", "1").find("hall/cell7/online 1"), std::string::npos);
    plc("cell_plc.py", "3");
    // What is retained is there for whoever comes later.
    const std::string said = hear("hall/cell7/#", "3");
    EXPECT_NE(said.find("hall/cell7/online 1\n"), std::string::npos) << said;
    const auto at = said.find("hall/cell7/result {");
    ASSERT_NE(at, std::string::npos) << said;
    const auto brace = said.find('{', at);
    const auto result = nlohmann::json::parse(said.substr(brace, said.find('\n', brace) - brace), nullptr, false);
    ASSERT_TRUE(result.is_object()) << said;
    EXPECT_EQ(result.at("run"), 3);
    EXPECT_EQ(result.at("result"), "rejected");
    EXPECT_EQ(result.at("serial"), "PY-0002");
    EXPECT_TRUE(wait_for([&] { return listener.out().find("\"while_measuring\":true") != std::string::npos; }))
        << listener.out();
    EXPECT_NE(listener.out().find("\"run\":1,\"program\":1,\"serial\":\"PY-0000\""), std::string::npos);

    // Without it parts are measured as before.
    broker->signal(SIGKILL);
    broker->wait(std::chrono::seconds(5));
    plc("cell_plc.py", "1");
    broker = start_broker("broker2");
    const std::string again = hear("hall/cell7/result", "1");
    EXPECT_NE(again.find("\"run\":4,"), std::string::npos) << again;
    EXPECT_NE(hear("hall/cell7/online", "1").find(" 1"), std::string::npos);
    end();
    EXPECT_NE(hear("hall/cell7/online", "1").find("hall/cell7/online 0"), std::string::npos);
    EXPECT_NE(cell->err().find("the broker is gone"), std::string::npos) << cell->err();
}

TEST_F(CellSystemTest, AnOpenDoorIsToldWhileItIsWaitedFor) {
    const std::string faults = folder / "faults.toml";
    std::ofstream(faults) << "[[fault]]\nwhat = \"door\"\nsamples = 60\nfor_s = 1.0\n";
    prepare(small_part, "6", faults);
    if (IsSkipped()) return;
    start({"--wait-s", "20"});
    plc("cell_faults.py", "door");
    end();
}

TEST_F(CellSystemTest, AMachineThatIsGoneIsToldAndTakenUpAgain) {
    prepare(long_part, "5");
    if (IsSkipped()) return;
    start();
    plc("cell_faults.py", "begin");
    const std::string url = machine->url();
    machine->process().signal(SIGKILL);
    machine->process().wait(std::chrono::seconds(5));
    // Before the PLC comes back: it is away for less than its watchdog, the machine for as long as the link is tried.
    auto gone = std::async(std::launch::async, [&] { plc("cell_faults.py", "machine gone"); });
    EXPECT_TRUE(wait_for([&] { return record().value("phase", "") == "done"; }));
    machine = std::make_unique<SimulatedMachine>(long_part, folder, std::vector<std::string>{"--speed", "20"},
                                                 url.substr(0, url.find('?')));
    gone.get();
    end();
}

TEST_F(CellSystemTest, TheEndOfTheServiceStopsTheMachineFirst) {
    prepare(long_part, "5");
    if (IsSkipped()) return;
    start();
    plc("cell_faults.py", "begin");
    end();
    EXPECT_EQ(record().at("phase"), "done");
    EXPECT_EQ(record().at("result"), 4);
    // It had gone on being alone for no longer than the script was away: either is true, and told.
    EXPECT_TRUE(record().at("reason") == 204 || record().at("reason") == 202) << record();
    const auto asked = run({cmmlive(), "doctor", "--machine", machine->url(), "--json"});
    EXPECT_NE(asked.out.find("\"state\":\"stopped\""), std::string::npos) << asked.out;
}

TEST_F(CellSystemTest, WhatItCannotServeItDoesNotBegin) {
    prepare(small_part, "0");
    if (IsSkipped()) return;
    const auto refused = [&](const std::vector<std::string>& change) {
        std::vector<std::string> arguments{cmmlive(), "cell", "--machine", machine->url(), "--runs", folder / "runs"};
        arguments.insert(arguments.end(), change.begin(), change.end());
        return run(arguments, std::chrono::seconds(10));
    };
    const std::string parts = folder / "parts";
    EXPECT_EQ(refused({"--parts", parts, "--plc", "modbus+tcp://0.0.0.0:0"}).exit_code, 3) << "open to all";
    EXPECT_EQ(refused({"--parts", parts, "--plc", "modbus+rtu:///dev/ttyS0"}).exit_code, 3);
    EXPECT_EQ(refused({"--parts", parts, "--plc", "modbus+tcp://127.0.0.1:0", "--plc-allow", "plc"}).exit_code, 3);
    EXPECT_EQ(refused({"--parts", folder.path()}).exit_code, 3) << "no programs";
    EXPECT_EQ(refused({"--parts", parts, "--plc-watchdog-ms", "10"}).exit_code, 3);
    EXPECT_EQ(refused({"--parts", parts, "--plc", "modbus+tcp://127.0.0.1:0", "--mqtt", "broker"}).exit_code, 3);
    std::ofstream(folder / "login") << "user\npassword\n";
    const auto open_login = refused({"--parts", parts, "--mqtt", "mqtt://127.0.0.1", "--mqtt-login", folder / "login"});
    EXPECT_EQ(open_login.exit_code, 3);
    EXPECT_NE(open_login.err.find("chmod 600"), std::string::npos) << open_login.err;
    std::ofstream(folder / "parts/1 again.toml") << text_of(small_part);
    const auto twice = refused({"--parts", parts, "--plc", "modbus+tcp://127.0.0.1:0"});
    EXPECT_EQ(twice.exit_code, 3);
    EXPECT_NE(twice.err.find("twice"), std::string::npos) << twice.err;
    std::filesystem::remove(folder / "parts/1 again.toml");
    std::filesystem::create_directory(folder / "runs");
    std::ofstream(folder / "runs/cell.json") << "{}";
    const auto damaged = refused({"--parts", parts, "--plc", "modbus+tcp://127.0.0.1:0"});
    EXPECT_EQ(damaged.exit_code, 3) << damaged.err;
    EXPECT_NE(damaged.err.find("cell.json"), std::string::npos) << damaged.err;
}

}  // namespace
}  // namespace cmm::test
