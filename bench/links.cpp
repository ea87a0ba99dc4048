// SPDX-License-Identifier: Apache-2.0
// How much of a link a scan uses: samples a second over TCP near and far, share of a serial line's capacity.
#include <algorithm>
#include <cstdio>

#include "bench/bench.hpp"
#include "bench/link_rig.hpp"
#include "tests/support/distant_network.hpp"
#include "tests/support/serial_wire.hpp"

namespace cmm::bench {
namespace {

using Kind = sim::Listen::Kind;
using test::DistantNetwork;
using test::SerialWire;

constexpr double baud = 115'200.0;
constexpr double bits_per_byte = 10.0;  // 8N1
constexpr int repeats = 3;

void print_spread(const std::string& what, std::vector<double> values, const std::string& unit,
                  const std::string& target = "") {
    std::sort(values.begin(), values.end());
    print(what, {values.front(), values[values.size() / 2], values.back()}, unit, target);
}

struct Distance {
    double round_trip_ms;
    std::size_t points;
    const char* options;
    const char* target;
};

double tcp_rate(const std::string& config_folder, const Distance& distance) {
    const LinkSimulator simulator(config_folder, {sim::Listen{}});
    const auto one_way = std::chrono::duration_cast<SteadyClock::duration>(
        std::chrono::duration<double, std::milli>(distance.round_trip_ms / 2.0));
    const DistantNetwork network(simulator.machine().port(), one_way);
    LinkHost host(network.modbus_url(distance.options));
    host.bring_up();
    CountingSink sink;
    const auto scanned = host.scan(ring(distance.points), sink);
    if (!scanned) throw std::runtime_error(scanned.error().text());
    return sink.rate();
}

void bench_tcp(const std::string& config_folder) {
    for (const Distance& distance :
         {Distance{0.0, 150'000, "in_flight=32", "> 4000"}, Distance{5.0, 60'000, "in_flight=32", "> 4000"},
          Distance{20.0, 25'000, "in_flight=32", "> 4000"}, Distance{20.0, 1'000, "in_flight=1", ""}}) {
        std::vector<double> rates;
        for (int k = 0; k < repeats; ++k)
            rates.push_back(tcp_rate(config_folder, distance));
        char what[80];
        std::snprintf(what, sizeof what, "Modbus TCP, %.0f ms round trip, %s", distance.round_trip_ms,
                      distance.options);
        print_spread(what, rates, "samples/s", distance.target);
    }
}

/// What a serial line carried in a time: bytes of both directions, since requests and replies take turns.
double share_percent(const drivers::LinkStats& before, const drivers::LinkStats& after, double seconds) {
    const auto bytes = after.bytes_sent - before.bytes_sent + after.bytes_received - before.bytes_received;
    return 100.0 * static_cast<double>(bytes) * bits_per_byte / baud / seconds;
}

/// Scans, with the path points on the line too; counted between the first samples and the last.
void bench_scan(const std::string& what, const std::string& config_folder, Kind kind, const std::string& scheme,
                const std::string& options, const std::string& target) {
    std::vector<double> rates, shares;
    for (int k = 0; k < repeats; ++k) {
        const SerialWire wire({.baud = baud, .bits_per_byte = bits_per_byte});
        const LinkSimulator simulator(config_folder, {on_serial(kind, wire.device())});
        LinkHost host(scheme + wire.host() + "?baud=115200&parity=none" + options);
        host.bring_up();
        CountingSink sink;
        drivers::LinkStats before, after;
        sink.first = [&] { before = host.machine().link_stats(); };
        sink.every = [&] { after = host.machine().link_stats(); };
        const auto scanned = host.scan(ring(1500), sink);
        if (!scanned) throw std::runtime_error(scanned.error().text());
        rates.push_back(sink.rate());
        shares.push_back(share_percent(before, after, sink.seconds()));
    }
    print_spread(what + ", scan", rates, "points/s");
    print_spread("  share of the line", shares, "%", target);
}

/// Fetches what the controller has recorded: samples alone on the line.
void bench_drain(const std::string& what, const std::string& config_folder, Kind kind, const std::string& scheme,
                 const std::string& options, const std::string& target) {
    constexpr std::size_t points = 4000;
    std::vector<double> rates, shares;
    for (int k = 0; k < repeats; ++k) {
        const SerialWire wire({.baud = baud, .bits_per_byte = bits_per_byte});
        const LinkSimulator simulator(config_folder, {sim::Listen{}, on_serial(kind, wire.device())});
        LinkHost first(simulator.machine().url());
        first.bring_up();
        CountingSink lost;  // a host whose disk keeps nothing, and is full at last
        lost.keeps = false;
        lost.give_up = points;
        static_cast<void>(first.scan(ring(2 * points), lost));
        LinkHost host(scheme + wire.host() + "?baud=115200&parity=none" + options, 2);
        const auto found = host.must(host.machine().connect());
        host.must(host.machine().begin_run(drivers::RunOrigin{found.boot_id, 0, 0}));
        host.must(host.machine().clear_fault());
        CountingSink sink;
        drivers::LinkStats before, after;
        sink.first = [&] { before = host.machine().link_stats(); };
        sink.every = [&] { after = host.machine().link_stats(); };
        host.must(host.machine().drain(sink));
        rates.push_back(sink.rate());
        shares.push_back(share_percent(before, after, sink.seconds()));
    }
    print_spread(what + ", samples alone", rates, "points/s", target);
    print_spread("  share of the line", shares, "%");
}

void bench_serial(const std::string& config_folder) {
    const std::string rtu = "modbus+rtu://";
    const std::string line = "line+serial://";
    bench_scan("Modbus RTU 115200 8N1, silence of 1.75 ms", config_folder, Kind::modbus_rtu, rtu, "", "");
    bench_scan("Modbus RTU 115200 8N1, gap_us=304", config_folder, Kind::modbus_rtu, rtu, "&gap_us=304", "> 95");
    bench_scan("line protocol 115200 8N1", config_folder, Kind::line_serial, line, "", "");
    bench_drain("Modbus RTU 115200 8N1, gap_us=304", config_folder, Kind::modbus_rtu, rtu, "&gap_us=304", "");
    bench_drain("line protocol 115200 8N1", config_folder, Kind::line_serial, line, "", "> 1000");
}

}  // namespace

void bench_links(const std::string& config_folder) try {
    bench_tcp(config_folder);
    bench_serial(config_folder);
} catch (const std::exception& failure) {
    std::printf("links: %s\n", failure.what());
}

}  // namespace cmm::bench
