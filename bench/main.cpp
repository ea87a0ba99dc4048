// SPDX-License-Identifier: Apache-2.0
#include <malloc.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "bench/bench.hpp"
#include "core/memory.hpp"

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

void print_one(const std::string& what, double value, const std::string& unit, const std::string& target) {
    print(what, {value, value, value}, unit, target);
}

double peak_memory_mb() {
    std::ifstream status("/proc/self/status");
    std::string word;
    double kilobytes = 0.0;
    while (status >> word && word != "VmHWM:") {
    }
    status >> kilobytes;
    return kilobytes / 1024.0;
}

void forget_peak_memory() {
    ::malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";  // proc(5): the peak begins anew at the present size
}

}  // namespace cmm::bench

int main(int count, char** arguments) {
    (void)cmm::core::keep_freed_memory();  // as in the program itself
    const auto executable = std::filesystem::read_symlink("/proc/self/exe");
    const std::string only = count > 1 ? arguments[1] : "";
    const auto wanted = [&](const char* name) { return only.empty() || only == name; };
    std::printf("%-58s %10s  %10s  %10s  %-10s %s\n", "", "min", "median", "max", "unit", "target");
    if (wanted("peers")) cmm::bench::bench_peers();
    if (wanted("airfoils")) cmm::bench::bench_airfoils();
    if (wanted("offsets")) cmm::bench::bench_offsets();
    if (wanted("gaps")) cmm::bench::bench_gaps();
    if (wanted("runs")) cmm::bench::bench_bad_runs();
    if (wanted("surface")) cmm::bench::bench_surface();
    if (wanted("compensation")) cmm::bench::bench_compensation_methods();
    if (wanted("live")) cmm::bench::bench_live();
    if (wanted("sections")) cmm::bench::bench_sections();
    const std::string config_folder = (executable.parent_path() / "../../config").string();
    if (wanted("final")) cmm::bench::bench_section_final(config_folder);
    if (wanted("links")) cmm::bench::bench_links(config_folder);
    const double for_each_s = count > 2 ? std::strtod(arguments[2], nullptr) : 20.0;
    if (wanted("stops")) cmm::bench::bench_stops(config_folder, for_each_s);
    if (wanted("plant")) cmm::bench::bench_plant(config_folder);
    if (wanted("chain")) cmm::bench::bench_chain(config_folder);
    return 0;
}
