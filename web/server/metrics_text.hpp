// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cmm::web {

/// Prometheus' text exposition format 0.0.4: families with help and type, then their values. A value; one thread.
class MetricsText {
  public:
    using Labels = std::vector<std::pair<std::string_view, std::string_view>>;

    /// `type`: "counter" (its name ends in _total) or "gauge".
    MetricsText& family(std::string_view name, std::string_view type, std::string_view help);
    /// Of the family begun last.
    MetricsText& value(double number, const Labels& labels = {});
    /// A family with a single value.
    MetricsText& one(std::string_view name, std::string_view type, std::string_view help, double number);
    /// A whole histogram: `counts` between the upper `bounds` (ascending), the last beyond them.
    MetricsText& histogram(std::string_view name, std::string_view help, std::span<const double> bounds,
                           std::span<const std::uint64_t> counts, double sum);
    const std::string& text() const { return text_; }

  private:
    void line(std::string_view name, const Labels& labels, double number);

    std::string text_, family_;
};

/// Durations in buckets fit for latencies of decisions: 1 ms to 10 s. A plain value.
class LatencyHistogram {
  public:
    void add(double seconds) noexcept;
    void print(MetricsText& text, std::string_view name, std::string_view help) const;

  private:
    static constexpr std::array bounds_s{0.001, 0.002, 0.003, 0.005, 0.0075, 0.01, 0.02, 0.03,
                                         0.05,  0.1,   0.2,   0.5,   1.0,    2.0,  5.0,  10.0};
    std::array<std::uint64_t, bounds_s.size() + 1> counts_{};
    double sum_s_ = 0.0;
};

}  // namespace cmm::web
