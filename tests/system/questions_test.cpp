// SPDX-License-Identifier: Apache-2.0
// The commands that answer and move nothing.
#include <gtest/gtest.h>

#include <filesystem>

#include "acquisition/plan.hpp"
#include "core/text.hpp"
#include "tests/support/outputs.hpp"
#include "tests/system/simulated_machine.hpp"

namespace cmm::test {
namespace {

constexpr const char* demo_part = "config/parts/demo.toml";

nlohmann::json json_of(const std::vector<std::string>& arguments) {
    const auto finished = run(arguments);
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    return nlohmann::json::parse(finished.out);
}

TEST(Questions, APlanOfTouchesSaysHowLongTheyTake) {
    const std::string part = "tests/system/parts/touched.toml";
    const auto scanned = json_of({cmmlive(), "plan", "--part", part, "--json"});
    const auto touched = json_of({cmmlive(), "plan", "--part", part, "--touch", "--json"});
    EXPECT_EQ(scanned["by_touches"], false);
    EXPECT_EQ(touched["by_touches"], true);
    EXPECT_EQ(scanned["hash"], touched["hash"]);
    const double places = touched["paths"][0]["points"], took_s = touched["paths"][0]["duration_s"];
    EXPECT_GT(took_s, 0.7 * places);  // 1 mm at 2 mm/s and back at 5
    EXPECT_LT(took_s, 1.5 * places);
    EXPECT_GT(touched["duration_s"], took_s);
    const auto notes = touched["findings"].dump();
    EXPECT_NE(notes.find("points, one by one, about"), std::string::npos) << notes;
    const auto printed = run({cmmlive(), "plan", "--part", part, "--touch"});
    EXPECT_NE(printed.out.find("mm to touch point by point, about "), std::string::npos) << printed.out;
    const TemporaryFolder folder;
    SimulatedMachine machine(part, folder);
    const auto dry = run({cmmlive(), "scan", "--machine", machine.url(), "--part", part, "--touch", "--dry-run"});
    EXPECT_EQ(dry.exit_code, 0) << dry.err;
    EXPECT_EQ(dry.out, run({cmmlive(), "plan", "--machine", machine.url(), "--part", part, "--touch"}).out);
    EXPECT_NE(dry.out.find("one by one"), std::string::npos) << dry.out;
}

TEST(Questions, APlanSaysTheSameOnTheTerminalAsDocumentAndAsFile) {
    const TemporaryFolder folder;
    const auto file = folder / "plan.json";
    const auto printed = run({cmmlive(), "plan", "--part", demo_part, "--out", file});
    EXPECT_EQ(printed.exit_code, 0) << printed.err;
    const auto document = json_of({cmmlive(), "plan", "--part", demo_part, "--json"});
    const auto content = core::read_file(file);
    ASSERT_TRUE(content);
    const auto plan = acquisition::parse_plan(*content, file);
    ASSERT_TRUE(plan) << plan.error().text();
    ASSERT_EQ(document.at("paths").size(), plan->paths.size());
    ASSERT_EQ(plan->paths.size(), 8U);
    for (std::size_t i = 0; i < plan->paths.size(); ++i) {
        EXPECT_EQ(document.at("paths")[i].at("points"), plan->paths[i].points.size());
        EXPECT_NEAR(document.at("paths")[i].at("z_mm").get<double>(), plan->paths[i].z_mm, 1e-4);
    }
    EXPECT_EQ(document.at("hash"), plan->hash);
    EXPECT_NE(printed.out.find("8 sections"), std::string::npos) << printed.out;
    EXPECT_NE(printed.out.find(plan->hash), std::string::npos) << printed.out;
}

TEST(Questions, AMachineIsAskedForItsLimitsAndWhatItIs) {
    const TemporaryFolder folder;
    SimulatedMachine machine(demo_part, folder);
    const auto found = json_of({cmmlive(), "doctor", "--machine", machine.url(), "--json"}).at("machine");
    EXPECT_EQ(found.at("model"), "cmmlive sim");
    EXPECT_EQ(found.at("state"), "idle");
    EXPECT_EQ(found.at("homed"), false);
    EXPECT_NEAR(found.at("lsb_mm").get<double>(), 1e-4, 1e-9);
    const auto printed = run({cmmlive(), "doctor", "--machine", machine.url()});
    EXPECT_EQ(printed.exit_code, 0) << printed.err;
    EXPECT_NE(printed.out.find("cmmlive sim SIM-0001"), std::string::npos) << printed.out;
    EXPECT_NE(printed.out.find("modbus+tcp"), std::string::npos) << printed.out;

    const auto dry = run({cmmlive(), "scan", "--machine", machine.url(), "--part", demo_part, "--dry-run"});
    EXPECT_EQ(dry.exit_code, 0) << dry.err;
    EXPECT_EQ(dry.out, run({cmmlive(), "plan", "--machine", machine.url(), "--part", demo_part}).out);
    EXPECT_EQ(machine.end().exit_code, 0);
    EXPECT_TRUE(read_csv(machine.log()).empty()) << "something was measured";
}

TEST(Questions, APartBeyondTheMachinesTravelIsRefused) {
    const TemporaryFolder folder;
    SimulatedMachine machine(demo_part, folder);
    // A blade that stands higher than the machine reaches.
    auto text = core::read_file(demo_part);
    ASSERT_TRUE(text);
    for (const auto& [from, to] :
         {std::pair{"to_mm = 85.0", "to_mm = 800.0"}, {"z_tip_mm = 100.0", "z_tip_mm = 900.0"}})
        text->replace(text->find(from), std::string_view(from).size(), to);
    ASSERT_TRUE(core::write_file(folder / "tall.toml", *text));
    EXPECT_EQ(run({cmmlive(), "plan", "--part", folder / "tall.toml"}).exit_code, 0) << "without a machine";
    const auto tall = run({cmmlive(), "plan", "--part", folder / "tall.toml", "--machine", machine.url()});
    EXPECT_EQ(tall.exit_code, 3) << tall.out;
    EXPECT_NE(tall.err.find("outside the machine's travel"), std::string::npos) << tall.err;
}

TEST(Questions, ConfigurationIsCheckedShownAndExplained) {
    const auto checked = run({cmmlive(), "config", "check", demo_part});
    EXPECT_EQ(checked.exit_code, 0) << checked.err;
    EXPECT_NE(checked.out.find("right"), std::string::npos) << checked.out;
    const auto part = nlohmann::json::parse(run({cmmlive(), "config", "show", demo_part}).out);
    EXPECT_EQ(part.at("nominal"), "parametric");
    EXPECT_EQ(part.at("heights_mm").size(), 8U);
    EXPECT_EQ(part.at("stylus_radius_mm"), 1.0);
    const auto faults = json_of({cmmlive(), "config", "check", "config/faults/door.toml", "--json"});
    EXPECT_EQ(faults["faults"][0], "door") << faults.dump();
    const auto machine = json_of({cmmlive(), "config", "check", "config/machines/sim.toml", "--json"});
    EXPECT_NE(machine.at("url").get<std::string>().find("modbus+tcp://127.0.0.1:1502"), std::string::npos);
    EXPECT_EQ(run({cmmlive(), "config", "show"}).exit_code, 3);

    // Every key that the explanation names is one that docs/part-file.md describes.
    const auto explained = run({cmmlive(), "config", "explain"});
    EXPECT_EQ(explained.exit_code, 0);
    const auto page = core::read_file("docs/part-file.md");
    ASSERT_TRUE(page);
    for (const char* key : {"radius_mm", "edge_density", "bad_points_percent", "toward_mm", "edge_profile_mm"}) {
        EXPECT_NE(explained.out.find(key), std::string::npos) << key;
        EXPECT_NE(page->find(key), std::string::npos) << key;
    }
}

}  // namespace
}  // namespace cmm::test
