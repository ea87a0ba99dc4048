// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "cell/cell.hpp"
#include "cell/mqtt_publisher.hpp"
#include "cell/plc_server.hpp"
#include "core/clock.hpp"
#include "web/server/metrics_text.hpp"

namespace cmm::app {

/// The fields of /api/cell and of the MQTT topics (docs/cell.md), without the outer braces.
std::string cell_fields(const cell::CellView& view);
std::string plc_fields(const cell::PlcServerCounts& counts);

/// What the cell told its PLC, counted. Any thread.
class CellMetrics {
  public:
    /// After each change.
    void hear(const cell::CellView& view);
    /// A rejection was in the registers so long after the sample that decided it had come in.
    void told(core::Duration latency);
    void print(web::MetricsText& text, const cell::CellView& view, const cell::PlcServerCounts& counts) const;

  private:
    mutable std::mutex mutex_;
    std::map<std::string, std::uint64_t> results_;
    bool done_ = false;  // the result that stands is counted
    bool first_ = true;
    web::LatencyHistogram latency_;
};

/// What a broker was told.
void print_mqtt(web::MetricsText& text, const cell::MqttCounts& counts);

}  // namespace cmm::app
