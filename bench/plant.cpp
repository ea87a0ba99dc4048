// SPDX-License-Identifier: Apache-2.0
// One host process, many machines: durable points, lateness of a timer beside them, latencies, cost.
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <mutex>
#include <stdexcept>

#include "acquisition/scan_job.hpp"
#include "acquisition/section_finisher.hpp"
#include "bench/bench.hpp"
#include "bench/dense_blade.hpp"
#include "bench/plant_machines.hpp"
#include "drivers/registry.hpp"
#include "tests/system/compare_samples.hpp"

namespace cmm::bench {
namespace {

namespace asio = boost::asio;
using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t machine_count = 24;
constexpr DenseBlade blade{"plant", 8, 0.024, 2.0};  // 5000 points a section: 5 s at 1 kHz
constexpr auto tick = std::chrono::milliseconds(1);

double ms_since(SteadyClock::time_point then) {
    return std::chrono::duration<double, std::milli>(SteadyClock::now() - then).count();
}

std::string run_file(const std::filesystem::path& folder, std::size_t machine) {
    return folder / ("run-" + std::to_string(machine) + ".cmmrun");
}

double cpu_seconds() {
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

/// A timer of 1 ms on the host's loop. Every deadline counts, also those that passed while the loop was held up.
class LateTimer {
  public:
    explicit LateTimer(asio::io_context& context) : timer_(context) {}
    void begin() {
        timer_.expires_after(tick);
        wait();
    }
    void end() {
        ended_ = true;
        timer_.cancel();
    }
    const std::vector<double>& late_ms() const { return late_ms_; }

  private:
    void wait() {
        timer_.async_wait([this](const boost::system::error_code& cancelled) {
            if (cancelled || ended_) return;
            late_ms_.push_back(ms_since(timer_.expiry()));
            timer_.expires_at(timer_.expiry() + tick);
            wait();
        });
    }
    asio::steady_timer timer_;
    std::vector<double> late_ms_;
    bool ended_ = false;
};

/// The latencies of all sections, whichever thread tells of them.
class Latencies {
  public:
    void listen(acquisition::EventHub& events) {
        events.listen([this](const acquisition::Event& event) {
            const std::string key = "\"latency_ms\":";
            const auto at = event.payload.find(key);
            if (event.kind != acquisition::EventKind::section_final || at == std::string::npos) return;
            const std::lock_guard lock(mutex_);
            ms_.push_back(std::strtod(event.payload.c_str() + at + key.size(), nullptr));
        });
    }
    acquisition::LatencySummary summary() const { return acquisition::summarise(ms_); }

  private:
    std::mutex mutex_;
    std::vector<double> ms_;
};

/// One machine of the host, with its run on a strand of its own.
struct Station {
    Station(const asio::strand<asio::io_context::executor_type>& on, const core::Clock& clock,
            acquisition::Workers& workers, acquisition::ScanRequest what, std::unique_ptr<drivers::Machine> whom)
        : strand(on), events(clock), machine(std::move(whom)), job(std::move(what), *machine, clock, events, workers) {}
    asio::strand<asio::io_context::executor_type> strand;
    acquisition::EventHub events;
    std::unique_ptr<drivers::Machine> machine;
    acquisition::ScanJob job;
    acquisition::ScanOutcome outcome;
};

/// The host: one loop, one strand a machine.
class Host {
  public:
    /// What fails throws std::runtime_error.
    void add(const std::string& part_file, const std::string& url, const std::string& run_file) {
        auto request = scan_request(part_file, run_file);
        if (!request) throw std::runtime_error(request.error().text());
        const auto link = drivers::link_settings_from(url);
        if (!link) throw std::runtime_error(link.error().text());
        const auto strand = asio::make_strand(context_);
        auto machine = drivers::standard_registry().make(*link, {strand, clock_, stations_.size() + 1});
        if (!machine) throw std::runtime_error(machine.error().text());
        stations_.push_back(
            std::make_unique<Station>(strand, clock_, workers_, std::move(*request), std::move(*machine)));
        latencies_.listen(stations_.back()->events);
    }

    /// From the first connect to the last verdict; returns the seconds of it.
    double run() {
        const auto begun = SteadyClock::now();
        std::atomic<std::size_t> left = stations_.size();
        for (const auto& station : stations_) {
            auto done = [&, at = station.get()](const std::exception_ptr& thrown, acquisition::ScanOutcome outcome) {
                if (thrown) std::rethrow_exception(thrown);
                at->outcome = std::move(outcome);
                if (--left == 0) timer_.end();
            };
            asio::co_spawn(station->strand, station->job.run(), done);
        }
        timer_.begin();
        context_.run();
        return ms_since(begun) * 1e-3;
    }

    const std::vector<std::unique_ptr<Station>>& stations() const { return stations_; }
    const LateTimer& timer() const { return timer_; }
    acquisition::LatencySummary latency() const { return latencies_.summary(); }

  private:
    core::SystemClock clock_;
    acquisition::Workers workers_;
    asio::io_context context_;
    Latencies latencies_;
    LateTimer timer_{context_};
    std::vector<std::unique_ptr<Station>> stations_;
};

std::uint64_t lines_of(const std::filesystem::path& file) {
    std::ifstream in(file);
    return static_cast<std::uint64_t>(
        std::count(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>(), '\n'));
}

/// What the machines say they recorded against what the run files hold.
void print_samples(const Host& host, const std::filesystem::path& folder, double took_s) {
    std::uint64_t recorded = 0, kept = 0;
    std::size_t whole = 0;
    for (std::size_t k = 0; k < host.stations().size(); ++k) {
        const auto& outcome = host.stations()[k]->outcome;
        if (outcome.error) std::printf("  machine %zu: %s\n", k, outcome.error->text().c_str());
        const auto log = PlantMachines::log_of(folder, k);
        recorded += lines_of(log) - 1;
        kept += outcome.samples;
        const std::string wrong = test::compare_samples({run_file(folder, k)}, log);
        if (!wrong.empty()) std::printf("  machine %zu: %s\n", k, wrong.c_str());
        whole += wrong.empty() && !outcome.error ? 1 : 0;
    }
    const auto samples = static_cast<double>(recorded);
    print_one("plant of " + std::to_string(machine_count) + " machines at 1 kHz, samples in all", samples, "");
    print_one("  a second, ways between the sections included", samples / took_s, "samples/s");
    print_one("  run files with every sample once and in order", static_cast<double>(whole), "",
              std::to_string(machine_count));
    print_one("  lost (less than 0: doubled)", samples - static_cast<double>(kept), "samples", "0");
}

void print_summary(const std::string& what, const acquisition::LatencySummary& of, const std::string& target) {
    print(what + ", " + std::to_string(of.count) + " (p50 p99 max)", {of.p50_ms, of.p99_ms, of.max_ms}, "ms", target);
}

void measure(const std::string& config_folder, const std::filesystem::path& folder) {
    const std::string part = part_file(config_folder, folder, blade);
    PlantMachines machines(config_folder, part, folder, machine_count);
    forget_peak_memory();
    Host host;
    for (std::size_t k = 0; k < machine_count; ++k)
        host.add(part, machines.urls()[k], run_file(folder, k));
    const double cpu_before_s = cpu_seconds();
    const double took_s = host.run();
    const double cpu_s = cpu_seconds() - cpu_before_s;
    const double memory_mb = peak_memory_mb();
    const auto cost = machines.end();
    print_samples(host, folder, took_s);
    print_summary("  timer of 1 ms on the host's loop, late", acquisition::summarise(host.timer().late_ms()),
                  "p99 < 5");
    print_summary("  SectionFinal, 5000 points", host.latency(), "");
    print_one("  host, share of a core", 100.0 * cpu_s / took_s, "%");
    print_one("  machines (a process of their own), share of a core", 100.0 * cost.cpu_s / took_s, "%");
    print_one("  host, peak memory", memory_mb, "MB");
    print_one("  machines, peak memory", cost.memory_mb, "MB");
}

}  // namespace

void bench_plant(const std::string& config_folder) try {
    const auto folder = std::filesystem::temp_directory_path() / "cmmlive-bench-plant";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    measure(config_folder, folder);
    std::filesystem::remove_all(folder);
} catch (const std::exception& failure) {
    std::printf("plant: %s\n", failure.what());
}

}  // namespace cmm::bench
