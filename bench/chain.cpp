// SPDX-License-Identifier: Apache-2.0
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/strand.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <optional>

#include "acquisition/scan_job.hpp"
#include "bench/bench.hpp"
#include "drivers/registry.hpp"
#include "sim/simulator.hpp"

namespace cmm::bench {
namespace {

namespace asio = boost::asio;

/// The demo's blade, measured so densely that a run has some 100 000 samples.
std::string dense_part(const std::string& config_folder, const std::filesystem::path& folder) {
    std::ifstream in(config_folder + "/parts/demo.toml");
    std::ofstream out(folder / "dense.toml");
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("pitch_mm")) line = "pitch_mm = 0.02";
        if (line.starts_with("edge_density")) line = "edge_density = 2.0";
        out << line << "\n";
    }
    return folder / "dense.toml";
}

std::optional<acquisition::ScanOutcome> scan(const std::string& url, const std::string& part_file,
                                             const std::string& run_file) {
    auto link = drivers::link_settings_from(url);
    auto part = acquisition::load_part_file(part_file);
    if (!link || !part) return std::nullopt;
    acquisition::ScanRequest request;
    request.part = std::move(*part);
    auto nominal = acquisition::load_nominal(request.part.nominal);
    if (!nominal) return std::nullopt;
    request.nominal = *nominal;
    request.run_file = run_file;
    const core::SystemClock clock;
    acquisition::EventHub events(clock);
    asio::io_context context;
    const auto registry = drivers::standard_registry();
    auto machine = registry.make(*link, drivers::DriverContext{asio::make_strand(context), clock, 1});
    if (!machine) return std::nullopt;
    acquisition::ScanJob job(std::move(request), **machine, clock, events);
    std::optional<acquisition::ScanOutcome> outcome;
    auto done = [&](const std::exception_ptr&, acquisition::ScanOutcome result) { outcome = std::move(result); };
    asio::co_spawn(context, job.run(), done);
    context.run();
    return outcome;
}

}  // namespace

void bench_chain(const std::string& config_folder) {
    const auto folder = std::filesystem::temp_directory_path() / "cmmlive-bench-chain";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    sim::SimulatorOptions options;
    options.part_file = dense_part(config_folder, folder);
    options.machine_file = config_folder + "/machines/sim.toml";
    options.map_file = config_folder + "/maps/cmm-v1.toml";
    options.speed = 0.0;
    auto simulator = sim::Simulator::start(options);
    if (!simulator) {
        std::printf("chain: %s\n", simulator.error().text().c_str());
        return;
    }
    std::optional<acquisition::ScanOutcome> outcome;
    const auto spread =
        time_of(1, [&] { outcome = scan((*simulator)->url(), options.part_file, folder / "run.cmmrun"); });
    if (!outcome || outcome->error) {
        std::printf("chain: %s\n", outcome && outcome->error ? outcome->error->text().c_str() : "could not start");
        return;
    }
    const double rate = static_cast<double>(outcome->samples) / spread.median;
    print("whole chain: simulator, Modbus TCP, journal, live section", {rate, rate, rate}, "samples/s", "> 20000");
    print("  samples in that run", {0, static_cast<double>(outcome->samples), 0}, "", "");
    print("  SectionFinal after the section's last sample (p50 p99 max)",
          {outcome->section_final.p50_ms, outcome->section_final.p99_ms, outcome->section_final.max_ms}, "ms",
          "p99 < 20 ms");
    std::filesystem::remove_all(folder);
}

}  // namespace cmm::bench
