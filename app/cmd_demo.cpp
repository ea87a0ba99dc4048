// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>

#include "app/browser.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/scan_runner.hpp"
#include "core/text.hpp"
#include "sim/simulator.hpp"

namespace cmm::app {

namespace {

/// A person who watches gets the page without asking for it, on a free port; a demo that is over at once has none.
PageSettings page_of(const DemoOptions& options) {
    PageSettings page = options.page;
    page.show = options.browser && !options.json && browser_at_hand();
    if (page.show && page.listen.empty() && options.speed > 0.0) page.listen = "127.0.0.1:0";
    return page;
}

}  // namespace

int run_demo(const DemoOptions& options) {
    const auto folder = config_folder();
    if (!folder) return report(folder.error(), options.json);
    sim::SimulatorOptions simulator;
    simulator.part_file = options.part.empty() ? *folder + "/parts/demo.toml" : options.part;
    simulator.machine_file = *folder + "/machines/sim.toml";
    simulator.map_file = *folder + "/maps/cmm-v1.toml";
    simulator.speed = options.speed;
    simulator.seed = options.seed;
    auto machine = sim::Simulator::start(simulator);
    if (!machine) return report(machine.error(), options.json);

    // A demo is run again and again: its own earlier results give way, nothing else in the folder does.
    std::error_code ignored;
    for (const char* suffix : {"", "-wal", "-shm"}) {
        std::filesystem::remove(options.out + "/run.cmmrun" + suffix, ignored);
    }
    RunnerOptions runner;
    runner.machine = (*machine)->url();
    runner.part = simulator.part_file;
    runner.out = options.out;
    runner.events = options.events;
    runner.wait_s = options.wait_s;
    runner.page = page_of(options);
    runner.json = options.json;
    runner.title =
        "a simulated machine listens on " + (*machine)->url() + "; scanning " + simulator.part_file +
        (options.speed > 0.0 ? " at " + core::fixed(options.speed, 1) + " times real time" : " as fast as it goes");
    const int code = run_main_job(runner);
    (*machine)->stop();
    return code;
}

}  // namespace cmm::app
