// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

/// What the peers' programs share: the problem's files, the clock, the lines that they print. A program is given a
/// folder, does the tasks it can, writes <peer>.<task> there and prints "task min median max" in ms of CPU time.
namespace cmm::bench::peers {

/// CPU time of this thread, ms: other work on the machine does not count.
inline double now_ms() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

struct Times {
    double low = 0.0, median = 0.0, high = 0.0;
};

template <class Work>
Times time_ms(int repeats, const Work& work) {
    std::vector<double> all;
    for (int i = 0; i < repeats; ++i) {
        const double start = now_ms();
        work();
        all.push_back(now_ms() - start);
    }
    std::sort(all.begin(), all.end());
    return {all.front(), all[all.size() / 2], all.back()};
}

/// `share`: the part of the task that was timed, where the whole takes too long.
inline void report(const std::string& task, const Times& t, double share = 1.0) {
    std::printf("%s %.6f %.6f %.6f\n", task.c_str(), t.low / share, t.median / share, t.high / share);
    std::fflush(stdout);
}

inline std::vector<double> numbers(const std::string& file) {
    std::ifstream in(file);
    std::vector<double> values;
    for (double value = 0.0; in >> value;)
        values.push_back(value);
    return values;
}

inline void write(const std::string& file, const std::vector<double>& values, std::size_t columns) {
    std::FILE* out = std::fopen(file.c_str(), "w");
    if (out == nullptr) return;
    for (std::size_t i = 0; i < values.size(); ++i)
        std::fprintf(out, "%.17g%c", values[i], (i + 1) % columns == 0 ? '\n' : ' ');
    std::fclose(out);
}

/// A clamped cubic B-spline: knots, then controls x y.
struct Curve {
    std::vector<double> knots, controls;
    std::size_t count() const { return controls.size() / 2; }
};

inline Curve curve(const std::string& folder) {
    return {numbers(folder + "/curve.knots"), numbers(folder + "/curve.controls")};
}

/// Places at which a fit or an offset is written out and judged.
constexpr int judged_points = 4000;
/// Tolerances of the tasks, mm.
constexpr double fit_tolerance_mm = 4e-3, offset_mm = 0.5, offset_tolerance_mm = 1e-4;

}  // namespace cmm::bench::peers
