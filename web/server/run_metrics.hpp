// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>

#include "acquisition/events.hpp"
#include "drivers/link_stats.hpp"
#include "web/server/metrics_text.hpp"

namespace cmm::web {

/// What the runs of this process did, counted from their events. Any thread; `hear` costs a run some microseconds an
/// event.
class RunMetrics {
  public:
    void hear(const acquisition::Event& event);
    void print(MetricsText& text) const;

  private:
    using Counts = std::map<std::string, std::uint64_t>;
    void count(const acquisition::Event& event);
    static void print(MetricsText& text, const char* name, const char* label, const char* help, const Counts& counts);

    mutable std::mutex mutex_;
    std::uint64_t started_ = 0, samples_ = 0, sections_ = 0, early_ = 0;
    Counts verdicts_, decisions_, characteristics_, rejected_, faults_, holds_;
    LatencyHistogram section_latency_, early_latency_;
};

/// Health of a link since its machine was made.
void print_link(MetricsText& text, const drivers::LinkStats& link);

}  // namespace cmm::web
