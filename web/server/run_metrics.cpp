// SPDX-License-Identifier: Apache-2.0
#include "web/server/run_metrics.hpp"

#include <nlohmann/json.hpp>

namespace cmm::web {

using acquisition::EventKind;
using nlohmann::json;

namespace {

std::string word(const json& fields, const char* key) {
    const auto found = fields.find(key);
    return found != fields.end() && found->is_string() ? found->get<std::string>() : "unknown";
}

}  // namespace

void RunMetrics::hear(const acquisition::Event& event) {
    // Made on the way of the samples, and nothing in them is counted.
    if (event.kind == EventKind::section_updated) return;
    const std::lock_guard guard(mutex_);
    count(event);
}

void RunMetrics::count(const acquisition::Event& event) {
    const auto fields = json::parse("{" + event.payload + "}", nullptr, false);
    const auto number = [&](const char* key) {
        const auto found = fields.find(key);
        return found != fields.end() && found->is_number() ? found->get<double>() : -1.0;
    };
    constexpr double per_ms = 1e-3;
    switch (event.kind) {
        case EventKind::run_started:
            ++started_;
            break;
        case EventKind::sample_batch:
            samples_ += static_cast<std::uint64_t>(number("count"));
            break;
        case EventKind::section_final:
            ++sections_;
            if (number("latency_ms") >= 0.0) section_latency_.add(number("latency_ms") * per_ms);
            break;
        case EventKind::gate_decision:
            if (fields.value("while_measuring", false)) {
                ++early_;
                early_latency_.add(number("latency_ms") * per_ms);
            } else {
                ++decisions_[word(fields, "decision")];
            }
            break;
        case EventKind::characteristic_updated:
            ++characteristics_[word(fields, "decision")];
            break;
        case EventKind::point_rejected:
            ++rejected_[word(fields, "reason")];
            break;
        case EventKind::hold:
            ++holds_[word(fields, "code")];
            break;
        case EventKind::machine_fault:
            ++faults_[word(fields, "code")];
            break;
        case EventKind::run_stopped:
            ++verdicts_[fields.value("complete", false) ? word(fields, "verdict") : "incomplete"];
            break;
        default:
            break;
    }
}

void RunMetrics::print(MetricsText& text, const char* name, const char* label, const char* help, const Counts& counts) {
    text.family(name, "counter", help);
    for (const auto& [key, number] : counts)
        text.value(static_cast<double>(number), {{label, key}});
}

void RunMetrics::print(MetricsText& text) const {
    const std::lock_guard guard(mutex_);
    text.one("cmmlive_runs_started_total", "counter", "Runs begun.", static_cast<double>(started_));
    print(text, "cmmlive_runs_total", "verdict", "Runs ended; incomplete: by a stop, a fault or an early rejection.",
          verdicts_);
    text.one("cmmlive_samples_total", "counter", "Samples taken.", static_cast<double>(samples_));
    print(text, "cmmlive_points_rejected_total", "reason", "Points that were not used.", rejected_);
    text.one("cmmlive_sections_total", "counter", "Sections finished.", static_cast<double>(sections_));
    print(text, "cmmlive_section_decisions_total", "decision", "Decisions about sections, revised ones included.",
          decisions_);
    print(text, "cmmlive_characteristic_decisions_total", "decision",
          "Decisions about characteristics, revised ones included.", characteristics_);
    text.one("cmmlive_rejections_while_measuring_total", "counter",
             "Sections that were out of tolerance for certain before they were complete.", static_cast<double>(early_));
    print(text, "cmmlive_holds_total", "code", "Waits at rest for what may pass.", holds_);
    print(text, "cmmlive_faults_total", "code", "Errors that ended a run.", faults_);
    section_latency_.print(text, "cmmlive_section_latency_seconds",
                           "From the arrival of a section's last sample to its result.");
    early_latency_.print(text, "cmmlive_rejection_latency_seconds",
                         "From the arrival of the deciding samples to the rejection while measuring.");
}

void print_link(MetricsText& text, const drivers::LinkStats& link) {
    const auto counter = [&](const char* name, const char* help, std::uint64_t number) {
        text.one(name, "counter", help, static_cast<double>(number));
    };
    counter("cmmlive_link_exchanges_total", "Exchanges with the machine that were answered.", link.ok);
    text.family("cmmlive_link_errors_total", "counter", "Exchanges with the machine that failed.")
        .value(static_cast<double>(link.timeouts), {{"kind", "timeout"}})
        .value(static_cast<double>(link.closed), {{"kind", "closed"}})
        .value(static_cast<double>(link.invalid), {{"kind", "invalid"}});
    counter("cmmlive_link_exceptions_total", "Exceptions that the machine answered.", link.exceptions);
    counter("cmmlive_link_retries_total", "Exchanges repeated.", link.retries);
    counter("cmmlive_link_reconnects_total", "Connections made anew.", link.reconnects);
    counter("cmmlive_link_sent_bytes_total", "Bytes to the machine.", link.bytes_sent);
    counter("cmmlive_link_received_bytes_total", "Bytes from the machine.", link.bytes_received);
    counter("cmmlive_link_stops_total", "Stops put on the wire.", link.stops);
    std::array<double, drivers::LinkStats::buckets - 1> bounds_s{};
    double upper_us = 2.0;
    for (auto& bound : bounds_s) {
        bound = upper_us * 1e-6;
        upper_us *= 2.0;
    }
    text.histogram("cmmlive_link_round_trip_seconds", "Round trips to the machine.", bounds_s, link.histogram,
                   link.total_round_trip_us * 1e-6);
}

}  // namespace cmm::web
