// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>

#include "acquisition/json_text.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "drivers/serial_settings.hpp"
#include "sim/simulator.hpp"

namespace cmm::app {
namespace {

sim::SerialLine serial_line(const drivers::Endpoint& endpoint, drivers::Parity default_parity) {
    const auto settings = drivers::SerialSettings::of(endpoint, default_parity);
    sim::SerialLine line;
    line.path = settings.device;
    line.pty = endpoint.word("pty", "no") == "yes";
    line.baud = settings.baud;
    line.parity = static_cast<sim::SerialLine::Parity>(settings.parity);
    line.stop_bits = settings.stop_bits;
    return line;
}

core::Result<sim::Listen> listen_on(const std::string& url) {
    const auto endpoint = drivers::Endpoint::parse(url);
    if (!endpoint) return tl::unexpected(endpoint.error());
    sim::Listen listen;
    listen.unit = static_cast<std::uint8_t>(endpoint->integer("unit", 1));
    if (endpoint->scheme == "modbus+tcp") {
        listen.address = endpoint->host;
        listen.port = endpoint->port;
    } else if (endpoint->scheme == "modbus+rtu") {
        listen.kind = sim::Listen::Kind::modbus_rtu;
        listen.line = serial_line(*endpoint, drivers::Parity::even);
    } else if (endpoint->scheme == "line+serial") {
        listen.kind = sim::Listen::Kind::line_serial;
        listen.line = serial_line(*endpoint, drivers::Parity::none);
    } else {
        return core::fail(core::ErrorCode::usage,
                          url + ": the simulator speaks modbus+tcp, modbus+rtu and line+serial");
    }
    return listen;
}

core::Result<sim::SimulatorOptions> simulator_options(const SimOptions& options) {
    sim::SimulatorOptions simulator;
    simulator.part_file = options.part;
    simulator.machine_file = options.machine;
    simulator.map_file = options.map;
    simulator.speed = options.speed;
    simulator.seed = options.seed;
    simulator.log_file = options.log;
    simulator.fault_file = options.faults;
    simulator.on_fault = [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); };
    if (options.machine.empty() || options.map.empty()) {
        const auto folder = config_folder();
        if (!folder) return tl::unexpected(folder.error());
        if (options.machine.empty()) simulator.machine_file = *folder + "/machines/sim.toml";
        if (options.map.empty()) simulator.map_file = *folder + "/maps/cmm-v1.toml";
    }
    simulator.listen.clear();
    for (const std::string& url : options.listen) {
        const auto listen = listen_on(url);
        if (!listen) return tl::unexpected(listen.error());
        simulator.listen.push_back(*listen);
    }
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
    if (options.json) {
        std::string list;
        for (const std::string& url : (*simulator)->urls())
            list += (list.empty() ? "" : ",") + acquisition::json_string(url);
        std::printf("{%s}\n", acquisition::JsonFields()
                                  .add("url", (*simulator)->url())
                                  .add("port", (*simulator)->port())
                                  .raw("urls", "[" + list + "]")
                                  .text()
                                  .c_str());
    } else {
        for (const std::string& url : (*simulator)->urls())
            std::printf("listening on %s\n", url.c_str());
    }
    std::fflush(stdout);
    int signal = 0;
    sigwait(&signals, &signal);
    (*simulator)->stop();
    return 0;
}

}  // namespace cmm::app
