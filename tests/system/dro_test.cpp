// SPDX-License-Identifier: Apache-2.0
// Sections measured by hand on a readout that only prints: a foreign program on a pseudo-terminal, whose points come
// from formulas of its own.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <sstream>

#include "core/text.hpp"
#include "tests/support/outputs.hpp"
#include "tests/support/process.hpp"

namespace cmm::test {
namespace {

constexpr const char* digitised_part = "tests/system/parts/straight.toml";

struct Style {
    std::string name;
    std::vector<std::string> printer;
    std::string dro;  // the [dro] table of the machine file
    double rounding_mm;
};

/// The readout, and a scan that listens to it.
class ByHand {
  public:
    explicit ByHand(std::vector<std::string> printer) {
        std::vector<std::string> arguments{
            "/usr/bin/python3", "tests/peers/dro_printer.py", "--go", folder_ / "go", "--truth", folder_.path()};
        arguments.insert(arguments.end(), printer.begin(), printer.end());
        printer_ = std::make_unique<Process>(arguments, folder_ / "printer");
        EXPECT_TRUE(wait_for([&] { return printed().size() > 1; })) << printer_->wait(std::chrono::seconds(1)).err;
    }
    std::string device() const { return printed().front(); }
    std::string machine_file(const std::string& dro) const {
        const auto file = folder_ / "machine.toml";
        std::ofstream(file) << "[link]\nurl = \"dro+serial://" << device() << "?baud=9600\"\n[dro]\n" << dro;
        return file;
    }
    /// Starts the scan; the person begins when it listens.
    Process& scan(const std::string& machine, bool typing = false) {
        std::vector<std::string> arguments{cmmlive(),      "scan",  "--machine", machine,    "--part",
                                           digitised_part, "--out", out(),       "--events", folder_ / "events"};
        if (typing) {
            const auto keys = folder_ / "keys";
            EXPECT_EQ(::mkfifo(keys.c_str(), 0600), 0);
            keyboard_ = ::open(keys.c_str(), O_RDWR | O_CLOEXEC);
            arguments.insert(arguments.begin(), {"/bin/sh", "-c", "keys=$1; shift; exec \"$@\" <$keys", "sh", keys});
        }
        scan_ = std::make_unique<Process>(arguments, folder_ / "scan");
        EXPECT_TRUE(wait_for([&] { return events("PathStarted") > 0 || !scan_->running(); }));
        std::ofstream(folder_ / "go") << "go";
        return *scan_;
    }
    void type(const std::string& text) const {
        EXPECT_EQ(::write(keyboard_, text.data(), text.size()), static_cast<ssize_t>(text.size()));
    }
    std::string out() const { return folder_ / "out"; }
    std::size_t events(const std::string& kind) const {
        const auto text = core::read_file(folder_ / "events").value_or("");
        std::size_t count = 0;
        for (auto at = text.find("\"" + kind + "\""); at != std::string::npos;
             at = text.find("\"" + kind + "\"", at + 1))
            ++count;
        return count;
    }
    std::vector<std::string> printed() const {
        std::vector<std::string> lines;
        const std::string text = printer_->out();
        for (const auto line : core::split(text, '\n'))
            lines.emplace_back(line);
        return lines;
    }
    /// Largest distance of a section's contour from the readout's own.
    double off_truth_mm(const std::string& section) const {
        std::vector<Eigen::Vector2d> truth;
        std::ifstream in(folder_ / "truth.csv");
        double x = 0.0;
        double y = 0.0;
        for (char comma = 0; in >> x >> comma >> y;)
            truth.emplace_back(x, y);
        double worst = 0.0;
        for (const auto& row : read_contour(out() + "/" + section))
            worst = std::max(worst, distance_to_polyline(row.position_mm.head<2>(), truth));
        return worst;
    }
    const TemporaryFolder& folder() const { return folder_; }

    ~ByHand() {
        if (keyboard_ >= 0) ::close(keyboard_);
    }
    ByHand(const ByHand&) = delete;
    ByHand& operator=(const ByHand&) = delete;

  private:
    TemporaryFolder folder_;
    int keyboard_ = -1;
    std::unique_ptr<Process> printer_, scan_;
};

class DroStyles : public testing::TestWithParam<Style> {};

TEST_P(DroStyles, PointsTakenByHandBecomeJudgedSections) {
    auto printer = GetParam().printer;
    printer.insert(printer.end(), {"--z", "10", "20"});
    ByHand run(printer);
    const auto machine =
        GetParam().dro.empty() ? "dro+serial://" + run.device() + "?baud=9600" : run.machine_file(GetParam().dro);
    const auto scanned = run.scan(machine).wait(std::chrono::seconds(60));
    ASSERT_EQ(scanned.exit_code, 0) << scanned.err << scanned.out;
    ASSERT_TRUE(wait_for([&] { return run.printed().size() > 2; }));
    std::size_t points = 0;
    std::size_t garbled = 0;
    std::istringstream(run.printed()[1]) >> points >> garbled;
    const auto sections = read_csv(run.out() + "/sections.csv");
    ASSERT_EQ(sections.size(), 2U);
    for (const auto& section : sections) {
        EXPECT_EQ(section.at("closed"), "1");
        EXPECT_EQ(section.at("points"), std::to_string(points + 1));  // the start once more
    }
    EXPECT_EQ(run.events("LineGarbled"), garbled);
    EXPECT_EQ(garbled > 0, scanned.err.find("line not understood") != std::string::npos) << scanned.err;
    // Between points half a millimetre apart a spline departs from the true curve by less than this.
    for (const char* name : {"section-0.csv", "section-1.csv"})
        EXPECT_LT(run.off_truth_mm(name), 0.002 + GetParam().rounding_mm) << name;

    // What was measured by hand is a run like any other: judged again, and played again.
    const auto fitted = cmm::test::run({cmmlive(), "fit", run.out() + "/run.cmmrun", "--out", run.folder() / "fit"});
    EXPECT_EQ(fitted.exit_code, 0) << fitted.err;
    const auto again = cmm::test::run({cmmlive(), "scan", "--machine", "replay:" + run.out() + "/run.cmmrun", "--part",
                                       digitised_part, "--out", run.folder() / "again"});
    EXPECT_EQ(again.exit_code, 0) << again.err;
    for (const char* name : {"section-0.csv", "section-1.csv", "points.csv"}) {
        const auto scan = core::read_file(run.out() + "/" + name);
        EXPECT_EQ(core::read_file(run.folder() / "fit/" + name).value_or(""), scan.value_or("none")) << name;
        EXPECT_EQ(core::read_file(run.folder() / "again/" + name).value_or(""), scan.value_or("none")) << name;
    }
}

INSTANTIATE_TEST_SUITE_P(
    Styles, DroStyles,
    testing::Values(Style{"LettersByUrl", {"--noise", "--end", "crlf"}, "", 1e-4},
                    Style{"InchesTaggedByAPedal",
                          {"--noise", "--style", "tagged", "--end", "cr"},
                          "format = \"{tag} {w} {x} {y} {z}\"\npoint_tags = \"P\"\nunit = \"inch\"\ndecimals = 6\n",
                          3e-4},
                    Style{
                        "CountsOnRequest",
                        {"--style", "counts", "--end", "lf"},
                        "format = \"X{x},Y{y},Z{z},W{w}\"\nnumbers = \"integer\"\ncount = 0.0001\nrequest = \"P\\r\"\n"
                        "request_every_ms = 1\n",
                        1e-4}),
    [](const auto& style) { return style.param.name; });

TEST(Dro, APersonEndsTheRunAndWhatWasTakenIsKept) {
    ByHand run({"--points", "150"});
    Process& scan = run.scan("dro+serial://" + run.device());
    // One event at the first point and then one in 64 points or a tenth of a second.
    ASSERT_TRUE(wait_for([&] { return run.printed().size() > 2 && run.events("SampleBatch") == 150; }));
    scan.signal(SIGINT);
    const auto stopped = scan.wait(std::chrono::seconds(30));
    EXPECT_EQ(stopped.exit_code, 4) << stopped.err;  // the second section was not begun
    const auto sections = read_csv(run.out() + "/sections.csv");
    ASSERT_EQ(sections.size(), 1U);
    EXPECT_EQ(sections.front().at("points"), "150");
    EXPECT_EQ(sections.front().at("closed"), "0");
}

TEST(Dro, ATypedWordEndsASection) {
    ByHand run({"--points", "150"});
    Process& scan = run.scan("dro+serial://" + run.device(), true);
    ASSERT_TRUE(wait_for([&] { return run.events("SampleBatch") == 150; }));
    run.type("\n");  // asks for a point: this device cannot be asked
    run.type("e\n");
    ASSERT_TRUE(wait_for([&] { return run.events("PathStarted") == 2; }));
    run.type("e\n");
    const auto ended = scan.wait(std::chrono::seconds(30));
    EXPECT_EQ(ended.exit_code, 2) << ended.err;
    const auto sections = read_csv(run.out() + "/sections.csv");
    ASSERT_EQ(sections.size(), 2U);
    EXPECT_EQ(sections[0].at("points"), "150");
    EXPECT_EQ(sections[1].at("points"), "0");
    for (const auto& section : sections) {
        EXPECT_EQ(section.at("closed"), "0");
        for (const auto* name : {"chord", "te_radius", "profile_te"})
            EXPECT_EQ(section.at(std::string(name) + "_decision"), "not_evaluable") << name;
    }
    EXPECT_EQ(sections[1].at("profile_le_decision"), "not_evaluable");
}

TEST(Dro, SaysWhatItCannotDo) {
    ByHand run({"--points", "1"});
    const auto asked =
        cmm::test::run({cmmlive(), "plan", "--part", digitised_part, "--machine", "dro+serial://" + run.device()});
    EXPECT_EQ(asked.exit_code, 0) << asked.err;
    EXPECT_NE(asked.out.find("a person moves this machine"), std::string::npos) << asked.out;

    const auto broken = run.machine_file("format = \"X{x},Y{y}\"\n");
    const auto bad = cmm::test::run({cmmlive(), "doctor", "--machine", broken});
    EXPECT_EQ(bad.exit_code, 3);
    EXPECT_NE(bad.err.find("{z} must be there once"), std::string::npos) << bad.err;

    const auto absent = cmm::test::run({cmmlive(), "scan", "--machine", "dro+serial:///dev/cmmlive-none", "--part",
                                        digitised_part, "--out", run.folder() / "none"});
    EXPECT_EQ(absent.exit_code, 5) << absent.err;
    EXPECT_NE(absent.err.find("/dev/cmmlive-none"), std::string::npos) << absent.err;
}

TEST(Devices, AreListedWithTheirHolders) {
    ByHand run({"--points", "1"});
    const auto document = cmm::test::run({cmmlive(), "devices", run.device(), "--json"});
    ASSERT_EQ(document.exit_code, 0) << document.err;
    const auto devices = nlohmann::json::parse(document.out).at("devices");
    ASSERT_GE(devices.size(), 1U);
    EXPECT_EQ(devices.back().at("device"), run.device());
    EXPECT_EQ(devices.back().at("description"), "pseudo-terminal");
    ASSERT_EQ(devices.back().at("held_by").size(), 1U) << document.out;
    EXPECT_NE(devices.back().at("held_by")[0].at("program").get<std::string>().find("python"), std::string::npos);
    const auto printed = cmm::test::run({cmmlive(), "devices", run.device()});
    EXPECT_EQ(printed.exit_code, 0) << printed.err;
    EXPECT_NE(printed.out.find("held by python"), std::string::npos) << printed.out;

    EXPECT_EQ(cmm::test::run({cmmlive(), "devices"}).exit_code, 0);
    EXPECT_EQ(cmm::test::run({cmmlive(), "devices", "/dev/cmmlive-none"}).exit_code, 3);
}

}  // namespace
}  // namespace cmm::test
