// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

/// Measurements that are printed, never asserted: the machine may be busy. Times are wall time of one thread unless
/// said.
namespace cmm::bench {

struct Spread {
    double low = 0.0, median = 0.0, high = 0.0;
};

/// `repeats` runs of `work`, each timed; seconds.
Spread time_of(int repeats, const std::function<void()>& work);
void print(const std::string& what, const Spread& value, const std::string& unit, const std::string& target);
/// The same with a single value.
void print_one(const std::string& what, double value, const std::string& unit, const std::string& target = "");
/// Peak resident memory of this process, MB, since its start or since it was forgotten.
double peak_memory_mb();
void forget_peak_memory();

/// Samples a second and memory of a run of a million samples, from the simulator's FIFO over Modbus TCP into the
/// durable journal and the fitted sections; and how long a user waits for a section at the real pace.
void bench_chain(const std::string& config_folder);
/// Microseconds a sample in the live section, milliseconds a section fit, memory for a million samples.
void bench_sections();
/// Milliseconds of processor time from the points of a section to its judgement, blades of three families, with warm
/// and with empty caches.
void bench_section_final(const std::string& config_folder);
/// Microseconds a sample in the live spline: median, 99 % and worst, at the beginning of a long scan and after a
/// million.
void bench_live();
/// Blades of three families of which a stretch was not measured, anywhere and of any width: how far what counts as
/// measured is from the truth.
void bench_gaps();
/// Blades of three families with bad points in runs of one to five, low and high, of 600, 1000 and 2000 points: how
/// many of the bad ones are missed and of the good ones lost.
void bench_bad_runs();
/// Airfoils of 60 mm chord and their ball centres, 100 scans each, spaced three ways: errors of the smoothing splines
/// and of the contour; root mean square, largest of a scan on average, largest of all.
void bench_airfoils();
/// Microseconds an offset contour of 2000 points and the offset as a spline, with its true error.
void bench_offsets();

/// The kernel beside FITPACK, Open CASCADE and SISL, as far as they are here, on the same data: times and errors.
void bench_peers();

/// A surface through 100 and 566 rows of unequal length: times, errors, memory, Newton steps with and without the warm
/// start; closest points on it; beside FITPACK, Open CASCADE and SISL, as far as they are here.
void bench_surface();
/// Blades of three families compensated by the surface of ball centres: errors and milliseconds a section.
void bench_compensation();
/// The same blades by every method of compensation: the table of docs/compensation.md.
void bench_compensation_methods();

/// Samples a second over Modbus TCP on near and distant links; points a second and share of the capacity of a serial
/// line with Modbus RTU and the line protocol.
void bench_links(const std::string& config_folder);
/// Milliseconds from the call of a stop to its arrival at the controller, at random instants of a scan, over each link.
void bench_stops(const std::string& config_folder, double for_each_link_s);
/// A plant: one host process with 24 machines that measure at 1 kHz. Whether every sample is in its run file once, how
/// late a timer of the host is beside them, what it costs.
void bench_plant(const std::string& config_folder);

}  // namespace cmm::bench
