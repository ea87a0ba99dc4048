// SPDX-License-Identifier: Apache-2.0
#include "sim/simulator.hpp"

#include <array>
#include <mutex>
#include <thread>
#include <utility>

#include "core/clock.hpp"
#include "core/rng.hpp"
#include "sim/controller.hpp"
#include "sim/fault_play.hpp"
#include "sim/faulty_wire.hpp"
#include "sim/line_protocol.hpp"
#include "sim/modbus_wire.hpp"
#include "sim/register_bank.hpp"
#include "sim/truth_log.hpp"
#include "sim/wire_server.hpp"

namespace cmm::sim {
namespace {

constexpr int tick_ms = 1;       // in motion: a sample reaches the FIFO this late at most
constexpr int rest_tick_ms = 5;  // the heartbeat changes every 20 ms at least

/// Another number for each start, and never 0.
std::uint16_t new_boot_id(const core::Clock& clock) {
    core::Rng mix(static_cast<std::uint64_t>(clock.utc_ns()));
    return static_cast<std::uint16_t>(1 + mix.below(65535));
}

std::string line_options(const SerialLine& line) {
    constexpr std::array parity{"none", "even", "odd"};
    return "baud=" + std::to_string(line.baud) + "&parity=" + parity[static_cast<std::size_t>(line.parity)] +
           "&stop_bits=" + std::to_string(line.stop_bits);
}

}  // namespace

/// Everything the thread works with; it is joined before any of it goes.
struct Simulator::Parts {
    SimulatorOptions options;
    core::SystemClock clock;
    std::unique_ptr<TruthLog> log;
    std::unique_ptr<Controller> controller;
    std::unique_ptr<RegisterBank> bank;
    std::unique_ptr<FaultPlay> faults;  // nullptr: nothing breaks
    std::unique_ptr<WireServer> server;
    std::uint16_t port = 0;
    std::vector<std::string> urls;
    std::mutex stop_mutex;
    std::thread thread;

    void serve() {
        server->run([this] {
            if (faults) faults->step();
            const bool more = controller->step();
            if (log) log->flush_if_due(clock.now());
            if (more) return 0;
            return controller->state() == MachineState::idle ? rest_tick_ms : tick_ms;
        });
    }

    void record(const SampleTruth& truth) {
        if (log) log->write(truth, controller->options().boot_id);
        if (faults) faults->count_sample();
    }

    std::unique_ptr<WireProtocol> speak(FaultyWire::Kind kind, std::unique_ptr<WireProtocol> protocol) {
        if (!faults) return protocol;
        return std::make_unique<FaultyWire>(kind, std::move(protocol), *faults);
    }

    /// Errors: those of the server.
    core::Status listen(const Listen& on);
    /// Errors: those of the plan.
    core::Status load_faults();
};

core::Status Simulator::Parts::load_faults() {
    if (options.fault_file.empty()) return {};
    const auto plan = load_fault_plan(options.fault_file);
    if (!plan) return tl::unexpected(plan.error());
    auto tell = [this](const std::string& line) {
        if (options.on_fault) options.on_fault(line);
    };
    faults = std::make_unique<FaultPlay>(*plan, options.seed, *controller, clock, std::move(tell));
    return {};
}

core::Status Simulator::Parts::listen(const Listen& on) {
    if (on.kind == Listen::Kind::modbus_tcp) {
        const auto bound = server->listen(on.address, on.port, [this] {
            return speak(FaultyWire::Kind::tcp, std::make_unique<MbapProtocol>(*bank));
        });
        if (!bound) return tl::unexpected(bound.error());
        if (port == 0) port = *bound;
        urls.push_back("modbus+tcp://" + on.address + ":" + std::to_string(*bound) + "?unit=1");
        return {};
    }
    if (on.kind == Listen::Kind::line_serial) {
        urls.push_back("line+serial://" + on.line.path + "?" + line_options(on.line));
        return server->open(
            on.line, [this] { return speak(FaultyWire::Kind::line, std::make_unique<LineProtocol>(*controller)); });
    }
    urls.push_back("modbus+rtu://" + on.line.path + "?" + line_options(on.line) + "&unit=" + std::to_string(on.unit));
    return server->open(on.line, [this, unit = on.unit] {
        return speak(FaultyWire::Kind::rtu, std::make_unique<RtuProtocol>(*bank, unit));
    });
}

Simulator::Simulator(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {
    parts_->thread = std::thread([parts = parts_.get()] { parts->serve(); });
}

Simulator::~Simulator() {
    stop();
}

core::Result<std::unique_ptr<Simulator>> Simulator::start(const SimulatorOptions& options) {
    if (options.listen.empty()) return core::fail(core::ErrorCode::usage, "nothing to listen on");
    if (!(options.speed >= 0.0)) return core::fail(core::ErrorCode::usage, "the speed must be 0 or more");
    auto parts = std::make_unique<Parts>();
    parts->options = options;
    auto machine = load_machine_settings(options.machine_file);
    if (!machine) return tl::unexpected(machine.error());
    const auto map = load_register_map(options.map_file);
    if (!map) return tl::unexpected(map.error());
    if (map->count_mm > 0.0) machine->lsb_mm = map->count_mm;
    auto part = load_part(options.part_file);
    if (!part) return tl::unexpected(part.error());
    ControllerOptions controller{
        std::move(*machine), std::move(*part), options.speed, options.seed, new_boot_id(parts->clock), {}, {}};
    if (!options.log_file.empty()) {
        auto log = TruthLog::open(options.log_file);
        if (!log) return tl::unexpected(log.error());
        parts->log = std::move(*log);
    }
    if (options.on_stop) controller.on_stop = [tell = options.on_stop](StopKind) { tell(); };
    controller.on_sample = [at = parts.get()](const SampleTruth& truth) { at->record(truth); };
    parts->controller = std::make_unique<Controller>(std::move(controller), parts->clock);
    parts->bank = std::make_unique<RegisterBank>(*parts->controller, *map);
    if (auto loaded = parts->load_faults(); !loaded) return tl::unexpected(loaded.error());
    auto server = WireServer::make();
    if (!server) return tl::unexpected(server.error());
    parts->server = std::move(*server);
    for (const Listen& on : options.listen)
        if (auto listening = parts->listen(on); !listening) return tl::unexpected(listening.error());
    return std::unique_ptr<Simulator>(new Simulator(std::move(parts)));
}

std::uint16_t Simulator::port() const {
    return parts_->port;
}

const std::vector<std::string>& Simulator::urls() const {
    return parts_->urls;
}

void Simulator::stop() {
    const std::lock_guard lock(parts_->stop_mutex);
    if (!parts_->thread.joinable()) return;
    parts_->server->stop();
    parts_->thread.join();
    parts_->log.reset();
}

}  // namespace cmm::sim
