// SPDX-License-Identifier: Apache-2.0
// A blade on a simulated machine that errs in every way that [uncertainty] knows, over the wire: what is measured is
// off, and lies within what is stated. The simulator errs by formulas of its own.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "tests/support/outputs.hpp"
#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

using nlohmann::json;

/// The demo's blade, shorter; `alignment`, `uncertainty` and `actual` are keys of their tables.
std::string part_text(const std::string& alignment, const std::string& uncertainty, const std::string& actual) {
    return "[part]\nname = \"blade\"\n[nominal]\nkind = \"parametric\"\n[nominal.blade]\nchord_root_mm = 60.0\n"
           "chord_tip_mm = 52.0\nthickness_root_mm = 6.0\nthickness_tip_mm = 4.0\ncamber_deg = 28.0\n"
           "stagger_root_deg = 24.0\nstagger_tip_deg = 38.0\nle_radius_mm = 0.4\nte_radius_mm = 0.25\nlean_x_deg = "
           "1.0\n"
           "lean_y_deg = 2.0\nz_root_mm = 0.0\nz_tip_mm = 100.0\n[stylus]\nradius_mm = 1.0\nshank_radius_mm = 0.7\n"
           "length_mm = 50.0\n[scan]\nheights_mm = [20, 50, 80]\npitch_mm = 0.4\nmax_speed_mm_s = 40.0\n[gate]\n"
           "profile_mm = 0.10\nedge_profile_mm = 0.08\n[alignment]\nkind = \"" +
           alignment + "\"\n[uncertainty]\n" + uncertainty +
           "[[characteristic]]\nname = \"chord\"\nmethod = \"CALIPER\"\n[[characteristic]]\nname = \"stagger\"\n"
           "[[characteristic]]\nname = \"area\"\n[[characteristic]]\nname = \"displacement_x\"\n"
           "[[characteristic]]\nname = \"displacement_y\"\n[[characteristic]]\nname = \"twist\"\n"
           "[[characteristic]]\nname = \"le_thickness\"\ndistance_mm = 3.0\n[[characteristic]]\nname = \"lean_x\"\n"
           "[[characteristic]]\nname = \"lean_y\"\n[[characteristic]]\nname = \"relative_twist\"\n"
           "[[characteristic]]\nname = \"bow_true_position\"\n[actual]\nkind = \"nominal\"\nnoise_um = 0.5\n"
           "bad_points_percent = 1.0\n" +
           actual;
}

json result_in(const std::string& out) {
    std::ifstream in(out + "/result.json");
    return json::parse(in, nullptr, false);
}

/// Every characteristic of sections and part that is known: as profiles are 0 and the nominal is what lies there, how
/// far it is off.
void each_error(const json& result, const std::function<void(const std::string&, double error, double u95)>& visit) {
    const auto look = [&](const json& c, const std::string& where) {
        if (!c.at("value").is_number()) return;
        const std::string name = c.at("name");
        const bool width = name.starts_with("profile_");
        if (!width && !c.at("nominal").is_number()) return;
        const double nominal = width ? 0.0 : c.at("nominal").get<double>();
        visit(where + name, c.at("value").get<double>() - nominal, c.at("u95").get<double>());
    };
    for (const auto& section : result.at("sections"))
        for (const auto& c : section.at("characteristics"))
            look(c, "section " + section.at("index").dump() + " ");
    for (const auto& c : result.at("characteristics"))
        look(c, "part ");
}

struct Uncertainty : testing::Test {
    TemporaryFolder folder;

    std::string write(const std::string& name, const std::string& text) const {
        const std::string file = folder / name;
        std::ofstream(file) << text;
        return file;
    }
    /// With a machine file that knows the figures.
    json scanned(const std::string& name, const std::string& part, const std::string& figures) {
        TemporaryFolder machine_folder;
        SimulatedMachine machine(part, machine_folder, {"--speed", "0"});
        EXPECT_FALSE(machine.url().empty()) << machine.process().out();
        const std::string file =
            write(name + "-machine.toml", "[link]\nurl = \"" + machine.url() + "\"\n[uncertainty]\n" + figures);
        const auto done = Process(scan_command(file, part, folder / name, false), folder / (name + "-scan"))
                              .wait(std::chrono::seconds(120));
        EXPECT_EQ(done.exit_code, 0) << done.err << done.out;
        return result_in(folder / name);
    }
};

const std::string figures = "length_um = 1.9\nlength_k_mm_per_um = 300\nprobing_form_um = 1.9\nprobing_size_um = 1.9\n";
const std::string warm =
    "part_temperature_c = 22.0\ntemperature_standard_k = 0.5\nexpansion_um_m_k = 11.5\n"
    "expansion_standard_um_m_k = 0.6\n";
// Each within its figures: the ball by 0.7 um of 0.95, lobes of 0.8 um of 0.95, axes by 2.5 um/m of 3.3; 2.4 K instead
// of 2 make 27.6 um/m.
const std::string errs =
    "ball_error_um = 0.7\nlobes_um = 0.8\nlobes = 3\nscale_um_m = [2.5, -2.0, 1.5]\nsquareness_um_m = [2.0, -1.5, "
    "2.0]\ngrowth_um_m = 27.6\n";

TEST_F(Uncertainty, HoldsWhatTheMachineDoes) {
    for (const std::string alignment : {"none", "section", "blade"}) {
        const auto part = write(alignment + ".toml", part_text(alignment, warm, errs));
        const auto result = scanned(alignment, part, figures);
        std::size_t compared = 0, beyond_noise = 0;
        each_error(result, [&](const std::string& name, double error, double u95) {
            ++compared;
            EXPECT_LE(std::abs(error), u95) << alignment << ": " << name;
        });
        EXPECT_GT(compared, 30U);
        // Not because nothing was off: the same points, judged without figures, lie outside of what the noise allows.
        const auto plain = write(alignment + "-plain.toml", part_text(alignment,
                                                                      "length_um = 0\nlength_k_mm_per_um = "
                                                                      "1000000\nprobing_form_um = "
                                                                      "0\nprobing_size_um = 0\n",
                                                                      errs));
        const auto again = run({cmmlive(), "fit", folder / (alignment + "/run.cmmrun"), "--part", plain, "--out",
                                folder / (alignment + "-plain")});
        ASSERT_EQ(again.exit_code, 0) << again.err;
        each_error(result_in(folder / (alignment + "-plain")), [&](const std::string&, double error, double u95) {
            beyond_noise += std::abs(error) > u95 ? 1 : 0;
        });
        EXPECT_GT(beyond_noise, 8U) << alignment;
    }
}

TEST_F(Uncertainty, IsKnownToWhoeverJudgesTheRunLater) {
    const auto part = write("part.toml", part_text("blade", warm, errs));
    const auto result = scanned("run", part, figures);
    EXPECT_NEAR(result.at("uncertainty").at("figures").at("length_mm").get<double>(), 1.9e-3, 1e-9);
    const auto fit = run({cmmlive(), "fit", folder / "run/run.cmmrun", "--out", folder / "fit"});
    EXPECT_EQ(fit.exit_code, 0) << fit.err;
    const auto replay =
        run({cmmlive(), "replay", folder / "run", "--out", folder / "replay"}, std::chrono::seconds(60));
    EXPECT_EQ(replay.exit_code, 0) << replay.err;
    for (const char* name : {"fit", "replay"}) {
        const auto again = result_in(folder / name);
        EXPECT_EQ(again.at("uncertainty"), result.at("uncertainty")) << name;
        EXPECT_EQ(again.at("sections"), result.at("sections")) << name;
        EXPECT_EQ(again.at("characteristics"), result.at("characteristics")) << name;
    }
}

TEST_F(Uncertainty, AnExpansionCanBeTakenOff) {
    const std::string corrected = warm + "expansion_correction = \"applied\"\n";
    const std::string grown = "growth_um_m = 230\n";
    auto hot = [](std::string text) { return text.replace(text.find("22.0"), 4, "40.0"); };
    const auto raw = scanned("raw", write("raw.toml", part_text("none", hot(warm), grown)), figures);
    const auto taken = scanned("taken", write("taken.toml", part_text("none", hot(corrected), grown)), figures);
    const auto chord_of = [](const json& result) {
        for (const auto& c : result.at("sections").at(1).at("characteristics"))
            if (c.at("name") == "chord_caliper") return c;
        return json();
    };
    const double off = chord_of(raw).at("value").get<double>() - chord_of(raw).at("nominal").get<double>();
    EXPECT_NEAR(off, 230e-6 * 56.0, 1e-3);
    EXPECT_LT(off, chord_of(raw).at("u95").get<double>());
    EXPECT_NEAR(chord_of(taken).at("value").get<double>(), chord_of(taken).at("nominal").get<double>(), 1e-3);
    EXPECT_LT(chord_of(taken).at("u95").get<double>(), 0.5 * chord_of(raw).at("u95").get<double>());
    each_error(taken,
               [](const std::string& name, double error, double u95) { EXPECT_LE(std::abs(error), u95) << name; });
}

}  // namespace
}  // namespace cmm::test
