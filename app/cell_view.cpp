// SPDX-License-Identifier: Apache-2.0
#include "app/cell_view.hpp"

#include "acquisition/json_text.hpp"

namespace cmm::app {

using acquisition::JsonFields;

std::string cell_fields(const cell::CellView& view) {
    JsonFields fields;
    fields.add("state", cell::to_string(view.state))
        .add("run", view.order.run)
        .add("program", view.order.program)
        .add("serial", view.order.serial)
        .add("result", cell::to_string(view.outcome.result))
        .add("reason", static_cast<std::uint16_t>(view.outcome.reason))
        .add("reason_text", cell::text_of(view.outcome.reason))
        .add("rejected_for_certain", view.rejected_for_certain)
        .add("may_be_moving", view.outcome.may_be_moving)
        .add("held_by", cell::text_of(view.held_by))
        .add("plc_lives", view.plc_lives);
    return fields.text();
}

std::string plc_fields(const cell::PlcServerCounts& counts) {
    return JsonFields()
        .add("connections", counts.connections)
        .add("accepted", counts.accepted)
        .add("refused", counts.refused)
        .add("requests", counts.requests)
        .add("exceptions", counts.exceptions)
        .add("garbled", counts.garbled)
        .text();
}

void CellMetrics::hear(const cell::CellView& view) {
    const std::lock_guard guard(mutex_);
    const bool done = cell::is_done(view.state);
    // A result that stood when the service began was counted by the one before.
    if (done && !done_ && !first_) ++results_[std::string(cell::to_string(view.outcome.result))];
    done_ = done;
    first_ = false;
}

void CellMetrics::told(core::Duration latency) {
    const std::lock_guard guard(mutex_);
    latency_.add(core::seconds(latency));
}

void CellMetrics::print(web::MetricsText& text, const cell::CellView& view, const cell::PlcServerCounts& counts) const {
    const std::lock_guard guard(mutex_);
    text.family("cmmlive_cell_state", "gauge", "1 for the state that the cell is in.");
    for (int i = 0; i < cell::cell_state_count; ++i) {
        const auto state = static_cast<cell::CellState>(i);
        text.value(state == view.state ? 1.0 : 0.0, {{"state", cell::to_string(state)}});
    }
    text.family("cmmlive_cell_results_total", "counter", "Results told to the PLC.");
    for (const auto& [result, number] : results_)
        text.value(static_cast<double>(number), {{"result", result}});
    text.one("cmmlive_cell_plc_lives", "gauge", "Whether the PLC's heartbeat goes on.", view.plc_lives ? 1.0 : 0.0);
    const auto counter = [&](const char* name, const char* help, std::uint64_t number) {
        text.one(name, "counter", help, static_cast<double>(number));
    };
    counter("cmmlive_cell_plc_losses_total", "How often the PLC was silent for too long.", view.plc_losses);
    text.one("cmmlive_plc_connections", "gauge", "Connections to the PLC's port.",
             static_cast<double>(counts.connections));
    counter("cmmlive_plc_connections_total", "Connections let in.", counts.accepted);
    counter("cmmlive_plc_refused_total", "Connections of addresses that may not.", counts.refused);
    counter("cmmlive_plc_requests_total", "Modbus requests.", counts.requests);
    counter("cmmlive_plc_exceptions_total", "Modbus requests that were answered by an exception.", counts.exceptions);
    counter("cmmlive_plc_garbled_total", "Connections closed because they spoke no Modbus.", counts.garbled);
    latency_.print(text, "cmmlive_cell_rejection_latency_seconds",
                   "From the arrival of the deciding sample to the rejection in the PLC's registers.");
}

void print_mqtt(web::MetricsText& text, const cell::MqttCounts& counts) {
    text.one("cmmlive_mqtt_connected", "gauge", "Whether the broker is there.", counts.connected ? 1.0 : 0.0);
    text.one("cmmlive_mqtt_waiting", "gauge", "Messages that wait for it.", static_cast<double>(counts.waiting));
    text.one("cmmlive_mqtt_published_total", "counter", "Messages that the broker has confirmed.",
             static_cast<double>(counts.published));
    text.one("cmmlive_mqtt_dropped_total", "counter", "Messages dropped because the queue was full.",
             static_cast<double>(counts.dropped));
}

}  // namespace cmm::app
