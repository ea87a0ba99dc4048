// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <regex>
#include <sstream>
#include <vector>

#include "core/clock.hpp"
#include "web/server/metrics_text.hpp"
#include "web/server/run_metrics.hpp"

namespace cmm::web {
namespace {

using acquisition::EventKind;

bool has_line(const std::string& text, const std::string& line) {
    return ("\n" + text).find("\n" + line + "\n") != std::string::npos;
}

TEST(MetricsText, IsTheFormatOfPrometheus) {
    MetricsText text;
    text.family("a_total", "counter", "What\nis \\ counted.").value(3.0, {{"kind", "x\"y\\z\n"}, {"b", "2"}});
    text.one("g", "gauge", "G.", 0.25);
    EXPECT_EQ(text.text(),
              "# HELP a_total What\\nis \\\\ counted.\n# TYPE a_total counter\n"
              "a_total{kind=\"x\\\"y\\\\z\\n\",b=\"2\"} 3\n"
              "# HELP g G.\n# TYPE g gauge\ng 0.25\n");
}

TEST(MetricsText, NumbersAreWhole) {
    MetricsText text;
    text.family("g", "gauge", "G.")
        .value(12345678901.0)
        .value(0.1)
        .value(std::numeric_limits<double>::infinity())
        .value(std::numeric_limits<double>::quiet_NaN());
    EXPECT_TRUE(has_line(text.text(), "g 12345678901")) << text.text();
    EXPECT_TRUE(has_line(text.text(), "g 0.1"));
    EXPECT_TRUE(has_line(text.text(), "g +Inf"));
    EXPECT_TRUE(has_line(text.text(), "g NaN"));
}

TEST(MetricsText, AHistogramCountsUpwards) {
    LatencyHistogram latency;
    for (const double seconds : {0.0005, 0.001, 0.004, 0.004, 60.0})
        latency.add(seconds);
    MetricsText text;
    latency.print(text, "l_seconds", "L.");
    const std::string& out = text.text();
    EXPECT_TRUE(has_line(out, "l_seconds_bucket{le=\"0.001\"} 2")) << "a bound belongs to its bucket: " << out;
    EXPECT_TRUE(has_line(out, "l_seconds_bucket{le=\"0.003\"} 2"));
    EXPECT_TRUE(has_line(out, "l_seconds_bucket{le=\"0.005\"} 4"));
    EXPECT_TRUE(has_line(out, "l_seconds_bucket{le=\"10\"} 4"));
    EXPECT_TRUE(has_line(out, "l_seconds_bucket{le=\"+Inf\"} 5"));
    EXPECT_TRUE(has_line(out, "l_seconds_count 5"));
    EXPECT_TRUE(has_line(out, "l_seconds_sum 60.0095")) << out;
}

TEST(RunMetrics, CountWhatARunTells) {
    const core::ManualClock clock;
    acquisition::EventHub hub(clock);
    RunMetrics metrics;
    hub.listen([&](const acquisition::Event& event) { metrics.hear(event); });
    hub.emit(EventKind::run_started, 0.0, "\"part\":\"p\"");
    hub.emit(EventKind::sample_batch, 0.0, "\"section\":0,\"first_seq\":1,\"count\":40");
    hub.emit(EventKind::sample_batch, 0.0, "\"section\":0,\"first_seq\":41,\"count\":2");
    hub.emit(EventKind::gate_decision, 0.0,
             "\"section\":0,\"decision\":\"reject\",\"while_measuring\":true,\"latency_ms\":2.5");
    hub.emit(EventKind::section_final, 0.0, "\"section\":0,\"latency_ms\":4.000");
    hub.emit(EventKind::section_final, 0.0, "\"section\":1,\"latency_ms\":null");
    hub.emit(EventKind::point_rejected, 0.0, "\"section\":0,\"reason\":\"fit_residual\"");
    hub.emit(EventKind::characteristic_updated, 0.0, "\"section\":0,\"decision\":\"accept\"");
    hub.emit(EventKind::gate_decision, 0.0, "\"section\":0,\"decision\":\"reject\"");
    hub.emit(EventKind::hold, 0.0, "\"code\":\"machine_door\"");
    hub.emit(EventKind::machine_fault, 0.0, "\"code\":\"machine_fault\"");
    hub.emit(EventKind::run_stopped, 0.0, "\"verdict\":\"reject\",\"complete\":true");
    hub.emit(EventKind::run_stopped, 0.0, "\"verdict\":\"undecided\",\"complete\":false");
    MetricsText text;
    metrics.print(text);
    for (const char* line :
         {"cmmlive_runs_started_total 1", "cmmlive_samples_total 42", "cmmlive_sections_total 2",
          "cmmlive_rejections_while_measuring_total 1", "cmmlive_rejection_latency_seconds_bucket{le=\"0.003\"} 1",
          "cmmlive_section_latency_seconds_count 1", "cmmlive_points_rejected_total{reason=\"fit_residual\"} 1",
          "cmmlive_section_decisions_total{decision=\"reject\"} 1", "cmmlive_holds_total{code=\"machine_door\"} 1",
          "cmmlive_characteristic_decisions_total{decision=\"accept\"} 1",
          "cmmlive_faults_total{code=\"machine_fault\"} 1", "cmmlive_runs_total{verdict=\"reject\"} 1",
          "cmmlive_runs_total{verdict=\"incomplete\"} 1"})
        EXPECT_TRUE(has_line(text.text(), line)) << line << "\n" << text.text();
}

TEST(RunMetrics, ALinksRoundTripsAreAHistogram) {
    drivers::LinkStats link;
    link.add_round_trip(1.5);
    link.add_round_trip(3.0);
    link.add_round_trip(1e9);
    link.timeouts = 2;
    MetricsText text;
    print_link(text, link);
    EXPECT_TRUE(has_line(text.text(), "cmmlive_link_round_trip_seconds_bucket{le=\"2e-06\"} 1")) << text.text();
    EXPECT_TRUE(has_line(text.text(), "cmmlive_link_round_trip_seconds_bucket{le=\"4e-06\"} 2"));
    EXPECT_TRUE(has_line(text.text(), "cmmlive_link_round_trip_seconds_bucket{le=\"+Inf\"} 3"));
    EXPECT_TRUE(has_line(text.text(), "cmmlive_link_errors_total{kind=\"timeout\"} 2"));
}

}  // namespace
}  // namespace cmm::web
