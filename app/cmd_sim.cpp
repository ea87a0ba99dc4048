// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>

#include "acquisition/json_text.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "drivers/endpoint.hpp"
#include "sim/simulator.hpp"

namespace cmm::app {
namespace {

core::Result<sim::SimulatorOptions> simulator_options(const SimOptions& options) {
    sim::SimulatorOptions simulator;
    simulator.part_file = options.part;
    simulator.machine_file = options.machine;
    simulator.map_file = options.map;
    simulator.speed = options.speed;
    simulator.seed = options.seed;
    simulator.log_file = options.log;
    if (options.machine.empty() || options.map.empty()) {
        const auto folder = config_folder();
        if (!folder) return tl::unexpected(folder.error());
        if (options.machine.empty()) simulator.machine_file = *folder + "/machines/sim.toml";
        if (options.map.empty()) simulator.map_file = *folder + "/maps/cmm-v1.toml";
    }
    if (options.listen.size() != 1)
        return core::fail(core::ErrorCode::usage, "this version listens on one endpoint: give --listen once");
    const auto endpoint = drivers::Endpoint::parse(options.listen.front());
    if (!endpoint) return tl::unexpected(endpoint.error());
    if (endpoint->scheme != "modbus+tcp") {
        return core::fail(core::ErrorCode::usage,
                          options.listen.front() + ": the simulator of this version speaks modbus+tcp");
    }
    simulator.address = endpoint->host;
    simulator.port = endpoint->port;
    return simulator;
}

}  // namespace

int run_sim(const SimOptions& options) {
    // Blocked before any thread starts, so that only sigwait below takes them.
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);

    const auto prepared = simulator_options(options);
    if (!prepared) return report(prepared.error(), options.json);
    auto simulator = sim::Simulator::start(*prepared);
    if (!simulator) return report(simulator.error(), options.json);
    const std::string url = (*simulator)->url();
    if (options.json) {
        std::printf("{%s}\n",
                    acquisition::JsonFields().add("url", url).add("port", (*simulator)->port()).text().c_str());
    } else {
        std::printf("listening on %s\n", url.c_str());
    }
    std::fflush(stdout);
    int signal = 0;
    sigwait(&signals, &signal);
    (*simulator)->stop();
    return 0;
}

}  // namespace cmm::app
