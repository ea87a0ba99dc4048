// SPDX-License-Identifier: Apache-2.0
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/strand.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>

#include "acquisition/scan_job.hpp"
#include "bench/bench.hpp"
#include "bench/dense_blade.hpp"
#include "drivers/registry.hpp"
#include "sim/simulator.hpp"

namespace cmm::bench {
namespace {

namespace asio = boost::asio;

struct Run {
    acquisition::ScanOutcome outcome;
    double planning_s = 0.0;   // to the first path
    double measuring_s = 0.0;  // from the first path to the verdict
    std::uint64_t exchanges = 0;
};

core::Result<Run> scan(const std::string& url, const std::string& part_file, const std::string& run_file) {
    auto link = drivers::link_settings_from(url);
    if (!link) return tl::unexpected(link.error());
    auto request = scan_request(part_file, run_file);
    if (!request) return tl::unexpected(request.error());
    const core::SystemClock clock;
    acquisition::EventHub events(clock);
    std::optional<double> first_path_s;
    double stopped_s = 0.0;
    events.listen([&](const acquisition::Event& event) {
        if (event.kind == acquisition::EventKind::path_started && !first_path_s) first_path_s = event.t_host_s;
        if (event.kind == acquisition::EventKind::run_stopped) stopped_s = event.t_host_s;
    });
    asio::io_context context;
    const auto registry = drivers::standard_registry();
    auto machine = registry.make(*link, drivers::DriverContext{asio::make_strand(context), clock, 1});
    if (!machine) return tl::unexpected(machine.error());
    acquisition::Workers workers;
    acquisition::ScanJob job(std::move(*request), **machine, clock, events, workers);
    Run run;
    auto done = [&](const std::exception_ptr& thrown, acquisition::ScanOutcome result) {
        if (thrown) std::rethrow_exception(thrown);
        run.outcome = std::move(result);
    };
    asio::co_spawn(context, job.run(), done);
    context.run();
    if (run.outcome.error) return tl::unexpected(*run.outcome.error);
    run.planning_s = first_path_s.value_or(0.0);
    run.measuring_s = stopped_s - run.planning_s;
    run.exchanges = (*machine)->link_stats().ok;
    return run;
}

/// Speed 0: as fast as it goes.
core::Result<Run> run_chain(const std::string& config_folder, const DenseBlade& blade, double speed) {
    const auto folder = std::filesystem::temp_directory_path() / "cmmlive-bench-chain";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    sim::SimulatorOptions options;
    options.part_file = part_file(config_folder, folder, blade);
    options.machine_file = config_folder + "/machines/sim.toml";
    options.map_file = config_folder + "/maps/cmm-v1.toml";
    options.speed = speed;
    auto simulator = sim::Simulator::start(options);
    if (!simulator) return tl::unexpected(simulator.error());
    auto run = scan((*simulator)->url(), options.part_file, folder / "run.cmmrun");
    std::filesystem::remove_all(folder);
    return run;
}

void print_latency(const std::string& what, const acquisition::LatencySummary& latency, const std::string& target) {
    print(what + ", " + std::to_string(latency.count) + " sections (p50 p99 max)",
          {latency.p50_ms, latency.p99_ms, latency.max_ms}, "ms", target);
}

/// A million samples as fast as they go, all in one run.
void bench_throughput(const std::string& config_folder) {
    forget_peak_memory();
    const double before_mb = peak_memory_mb();
    const auto run = run_chain(config_folder, {"million", 190, 0.024, 2.0}, 0.0);
    if (!run) {
        std::printf("chain: %s\n", run.error().text().c_str());
        return;
    }
    const auto samples = static_cast<double>(run->outcome.samples);
    print_one("whole chain: simulator, Modbus TCP, journal, sections", samples / run->measuring_s, "samples/s",
              "> 20000");
    print_one("  samples in that run", samples, "");
    print_one("  samples an exchange", samples / static_cast<double>(run->exchanges), "");
    print_one("  planning before its first path", run->planning_s, "s");
    print_one("  peak memory, simulator included (before: " + std::to_string(static_cast<int>(before_mb)) + " MB)",
              peak_memory_mb(), "MB");
    print_latency("  SectionFinal, 5000 points", run->outcome.latency.closed, "");
    print_latency("  decision, 5000 points", run->outcome.latency.decided, "");
}

/// What a user waits for at the real pace of a 1 kHz machine.
void bench_latency(const std::string& config_folder) {
    const auto run = run_chain(config_folder, {"real-time", 16, 0.064, 2.0}, 1.0);
    if (!run) {
        std::printf("chain at real time: %s\n", run.error().text().c_str());
        return;
    }
    const auto points = run->outcome.samples / run->outcome.result.sections.size();
    print_latency("real time, SectionFinal, " + std::to_string(points) + " points", run->outcome.latency.closed,
                  "p99 < 5");
    print_latency("real time, decision, " + std::to_string(points) + " points", run->outcome.latency.decided,
                  "p99 < 30");
}

}  // namespace

void bench_chain(const std::string& config_folder) {
    bench_throughput(config_folder);
    bench_latency(config_folder);
}

}  // namespace cmm::bench
