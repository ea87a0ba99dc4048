// SPDX-License-Identifier: Apache-2.0
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "bench/bench.hpp"

namespace cmm::bench {

Spread time_of(int repeats, const std::function<void()>& work) {
    std::vector<double> seconds;
    for (int i = 0; i < repeats; ++i) {
        const auto start = std::chrono::steady_clock::now();
        work();
        seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    std::sort(seconds.begin(), seconds.end());
    return {seconds.front(), seconds[seconds.size() / 2], seconds.back()};
}

void print(const std::string& what, const Spread& value, const std::string& unit, const std::string& target) {
    std::printf("%-58s %10.3f  %10.3f  %10.3f  %-10s %s\n", what.c_str(), value.low, value.median, value.high,
                unit.c_str(), target.c_str());
    std::fflush(stdout);
}

double peak_memory_mb() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace cmm::bench

int main() {
    const auto executable = std::filesystem::read_symlink("/proc/self/exe");
    std::printf("%-58s %10s  %10s  %10s  %-10s %s\n", "", "min", "median", "max", "unit", "target");
    cmm::bench::bench_sections();
    cmm::bench::bench_chain((executable.parent_path() / "../../config").string());
    return 0;
}
