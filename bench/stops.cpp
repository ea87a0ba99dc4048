// SPDX-License-Identifier: Apache-2.0
// How long a stop takes from the call at the host to the controller, at any instant of a scan.
#include <algorithm>
#include <atomic>
#include <boost/asio/steady_timer.hpp>
#include <cmath>
#include <cstdio>

#include "bench/bench.hpp"
#include "bench/link_rig.hpp"
#include "core/rng.hpp"
#include "tests/support/distant_network.hpp"
#include "tests/support/serial_wire.hpp"

namespace cmm::bench {
namespace {

using Kind = sim::Listen::Kind;
using test::DistantNetwork;
using test::SerialWire;

constexpr std::size_t most_stops = 1000;
constexpr std::size_t path_points = 150'000;  // more than are scanned before the stop

/// When the simulator saw the last stop; 0: none yet. Written by its thread.
using Arrival = std::atomic<std::int64_t>;

std::function<void()> noting(Arrival& arrival) {
    return [&arrival] {
        std::int64_t never = 0;
        arrival.compare_exchange_strong(never, SteadyClock::now().time_since_epoch().count());
    };
}

/// Scans, stops at a random instant and begins again; milliseconds of each stop.
std::vector<double> stops(LinkHost& host, Arrival& arrival, double longest_wait_ms, double for_each_s) {
    host.bring_up();
    core::Rng rng(7);
    std::vector<double> took_ms;
    const auto end = SteadyClock::now() + std::chrono::duration<double>(for_each_s);
    while (SteadyClock::now() < end && took_ms.size() < most_stops) {
        // On from where it stands: from elsewhere the way to the path would lead through the part.
        const auto at = host.must(host.machine().state()).position_mm;
        const auto path = ring(path_points, std::atan2(at.y(), at.x()));
        arrival = 0;
        SteadyClock::time_point asked{};
        boost::asio::steady_timer timer(host.io());
        timer.expires_after(core::from_ms(rng.uniform(0.0, longest_wait_ms)));
        timer.async_wait([&](const boost::system::error_code& cancelled) {
            if (cancelled) return;
            asked = SteadyClock::now();
            host.machine().stop(drivers::StopKind::controlled);
        });
        CountingSink sink;
        const auto scanned = host.scan(path, sink);
        if (scanned) throw std::runtime_error("a scan was over before it was stopped");
        if (arrival == 0) throw std::runtime_error("a scan ended without the stop: " + scanned.error().text());
        const auto arrived = SteadyClock::time_point(SteadyClock::duration(arrival.load()));
        took_ms.push_back(std::chrono::duration<double, std::milli>(arrived - asked).count());
        host.must(host.machine().clear_fault());
    }
    std::sort(took_ms.begin(), took_ms.end());
    return took_ms;
}

void print_stops(const std::string& what, const std::vector<double>& ms, const std::string& target) {
    const auto at = [&](double share) {
        return ms[std::min(ms.size() - 1, static_cast<std::size_t>(share * static_cast<double>(ms.size())))];
    };
    print(what + ", " + std::to_string(ms.size()) + " (p50 p99 max)", {at(0.5), at(0.99), ms.back()}, "ms", target);
}

void bench_tcp(const std::string& config_folder, int round_trip_ms, double for_each_s) {
    Arrival arrival{0};
    const LinkSimulator simulator(config_folder, {sim::Listen{}}, noting(arrival));
    const DistantNetwork network(simulator.machine().port(), std::chrono::microseconds(500 * round_trip_ms));
    LinkHost host(network.modbus_url());
    print_stops("stop, Modbus TCP, " + std::to_string(round_trip_ms) + " ms round trip",
                stops(host, arrival, 100.0, for_each_s), "p99 < 50");
}

void bench_serial(const std::string& what, const std::string& config_folder, Kind kind, const std::string& scheme,
                  double for_each_s) {
    Arrival arrival{0};
    const SerialWire wire({.baud = 115'200.0, .bits_per_byte = 10.0});
    const LinkSimulator simulator(config_folder, {on_serial(kind, wire.device())}, noting(arrival));
    LinkHost host(scheme + wire.host() + "?baud=115200&parity=none");
    print_stops("stop, " + what + " 115200 8N1", stops(host, arrival, 900.0, for_each_s), "p99 < 250");
}

}  // namespace

void bench_stops(const std::string& config_folder, double for_each_link_s) try {
    bench_tcp(config_folder, 0, for_each_link_s);
    bench_tcp(config_folder, 20, for_each_link_s);
    bench_serial("Modbus RTU", config_folder, Kind::modbus_rtu, "modbus+rtu://", for_each_link_s);
    bench_serial("line protocol", config_folder, Kind::line_serial, "line+serial://", for_each_link_s);
} catch (const std::exception& failure) {
    std::printf("stops: %s\n", failure.what());
}

}  // namespace cmm::bench
