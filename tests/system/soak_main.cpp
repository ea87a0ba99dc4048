// SPDX-License-Identifier: Apache-2.0
// A night in minutes (./run soak):
// soak [--hours 8] [--speed 20] [--fault-every-s 30] [--wire tcp|rtu|line] [--seed N] [--out FILE.csv]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/system/soak.hpp"

namespace {

using namespace cmm::test;

SoakOptions read_options(int argc, char** argv) {
    SoakOptions options;
    for (int i = 1; i + 1 < argc; i += 2) {
        const std::string key = argv[i], value = argv[i + 1];
        if (key == "--hours") options.hours = std::atof(value.c_str());
        if (key == "--speed") options.speed = std::atof(value.c_str());
        if (key == "--fault-every-s") options.fault_every_s = std::atof(value.c_str());
        if (key == "--seed") options.seed = std::strtoull(value.c_str(), nullptr, 10);
        if (key == "--out") options.watch_file = value;
        if (key == "--wire") options.wire = value == "rtu" ? Wire::rtu : value == "line" ? Wire::line : Wire::tcp;
    }
    return options;
}

void print(const char* who, const std::vector<Holdings>& seen) {
    if (seen.empty()) return;
    const auto [least, most] = std::minmax_element(
        seen.begin(), seen.end(), [](const Holdings& a, const Holdings& b) { return a.files < b.files; });
    std::printf(
        "%s: %.0f kB at first, %.0f kB at last, slope %+.1f kB an hour after the first tenth; %d to %d open files\n",
        who, seen.front().memory_kb, seen.back().memory_kb, memory_slope(seen), least->files, most->files);
}

}  // namespace

int main(int argc, char** argv) {
    const SoakOptions options = read_options(argc, argv);
    const SoakResult result = soak(options);
    int struck = 0;
    for (const auto& [kind, times] : result.faults)
        struck += times;
    std::printf("%.2f hours of the machine over %s: %d jobs, %llu samples, %d faults, %d resumes\n", result.hours,
                to_string(options.wire).c_str(), result.jobs, static_cast<unsigned long long>(result.samples), struck,
                result.resumes);
    for (const auto& [kind, times] : result.faults)
        std::printf("  fault %s: %d\n", kind.c_str(), times);
    for (const auto& [code, times] : result.endings)
        std::printf("  ended with %s: %d\n", code.c_str(), times);
    print("simulator, each second", result.simulator);
    print("host, at its largest in each job", result.host_at_its_largest);
    for (const std::string& wrong : result.wrong)
        std::printf("WRONG: %s\n", wrong.c_str());
    if (result.wrong.empty()) std::printf("no sample lost or doubled, nothing hung\n");
    return result.wrong.empty() ? 0 : 1;
}
