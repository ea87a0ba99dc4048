// SPDX-License-Identifier: Apache-2.0
#include "tests/system/fault_matrix.hpp"

namespace cmm::test {
namespace {

using Wires = std::vector<Wire>;
const Wires serial{Wire::rtu, Wire::line};
const Wires tcp{Wire::tcp};

// What the controller notices itself stops the machine as fast as it can brake.
constexpr double by_itself_ms = 250.0;
// Where nobody is left to tell it, its watchdog does: 500 ms (config/machines/sim.toml) and the braking.
constexpr double by_watchdog_ms = 500.0 + by_itself_ms;

/// The controller stops: the run ends with this code and can be gone on with.
FaultCase stops(std::string name, std::string error, bool lasting = false) {
    FaultCase fault;
    fault.name = std::move(name);
    fault.errors = {std::move(error)};
    fault.finishes = false;
    fault.stop_ms = by_itself_ms;
    fault.lasting = lasting;
    return fault;
}

/// The run goes on as if nothing had been.
FaultCase harmless(std::string name, Wires wires = {Wire::tcp, Wire::rtu, Wire::line}) {
    FaultCase fault;
    fault.name = std::move(name);
    fault.wires = std::move(wires);
    return fault;
}

/// The machine stops, the job waits at rest until it has passed and finishes by itself.
FaultCase waited_for(const std::string& name, double stop_ms) {
    FaultCase fault;
    fault.name = name + "-waited-for";
    fault.plan = name;
    fault.wait_s = "30";
    fault.errors = {"machine_watchdog"};  // of a host that got no processor for half a second
    fault.stop_ms = stop_ms;
    fault.spares_points = false;  // the rest of the section is another path with other noise
    return fault;
}

/// A refusal is an answer; where there can be none (samples, status) and where the controller is busy, it is asked
/// again.
FaultCase refusal(int code) {
    FaultCase fault;
    fault.name = "exception-" + std::to_string(code);
    fault.errors = {"protocol_invalid", "protocol_mismatch", "machine_refused"};
    return fault;
}

/// Nothing passes for longer than the watchdog time.
FaultCase silence(std::string name, bool finishes) {
    FaultCase fault;
    fault.name = std::move(name);
    fault.errors = {"machine_watchdog", "transport_timeout", "transport_connect", "transport_closed"};
    fault.finishes = finishes;
    fault.stop_ms = by_watchdog_ms;
    fault.speed = "4";
    fault.lasting = true;
    return fault;
}

/// Now and then three replies in a row get lost, which the watchdog notices.
FaultCase noisy(std::string name) {
    FaultCase fault;
    fault.name = std::move(name);
    fault.errors = {"machine_watchdog", "transport_timeout", "protocol_invalid"};
    return fault;
}

FaultCase of_host(std::string name, std::vector<std::string> errors, bool finishes) {
    FaultCase fault;
    fault.name = std::move(name);
    fault.errors = std::move(errors);
    fault.finishes = finishes;
    fault.stop_ms = by_watchdog_ms;
    return fault;
}

}  // namespace

std::vector<FaultCase> fault_cases() {
    std::vector<FaultCase> cases{
        stops("emergency-stop", "machine_emergency", true),
        stops("door", "machine_door", true),
        stops("temperature", "machine_temperature", true),
        stops("over-deflection", "machine_deflection"),
        stops("collision", "machine_fault"),
        stops("travel-limit", "machine_limit"),
        stops("encoder-jump", "machine_position", true),
        stops("fifo-overflow", "machine_overflow"),
        stops("lift-off-long", "machine_no_contact"),
        stops("restart", "machine_fault", true),
        stops("misclamped", "machine_no_contact"),
    };
    cases.back().curable = false;
    for (FaultCase& fault : cases) {
        fault.finishes = fault.name == "lift-off-long";  // unnoticed at the end of a section
        fault.spares_points = false;
    }
    for (const char* name : {"door", "emergency"}) {
        cases.push_back(stops(name + std::string("-anytime"), std::string("machine_") + name, true));
        cases.back().finishes = true;  // when the job is done already
    }
    for (const char* name : {"clock-jump-ahead", "clock-jump-back"})
        cases.push_back(harmless(name));
    for (const char* name : {"drift", "lift-off", "dirt", "part-shift"}) {
        cases.push_back(harmless(name));
        cases.back().spares_points = false;
    }
    for (int code = 1; code <= 5; ++code)
        cases.push_back(refusal(code));
    for (const char* name : {"exception-6", "delay-short", "delay", "lost-reply", "bad-crc", "split", "split-wide",
                             "merged", "duplicated", "stale", "truncated", "reordered", "closed", "cable"})
        cases.push_back(harmless(name));
    cases.push_back(harmless("wrong-unit", {Wire::tcp, Wire::rtu}));
    cases.push_back(harmless("half-open", tcp));
    cases.push_back(harmless("lost-request", serial));
    cases.push_back(harmless("overrun", serial));
    cases.push_back(silence("hang", true));
    cases.push_back(silence("cable-long", false));
    cases.push_back(noisy("dropped-bytes"));
    cases.push_back(noisy("flipped-bytes"));
    cases.push_back(of_host("host-killed", {}, true));
    cases.push_back(of_host("disk-slow", {}, true));
    cases.push_back(of_host("disk-full", {"journal_full"}, false));
    for (const char* name : {"door", "temperature", "disk-full"})
        cases.push_back(waited_for(name, by_itself_ms));
    return cases;
}

}  // namespace cmm::test
