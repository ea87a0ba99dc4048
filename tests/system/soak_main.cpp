// SPDX-License-Identifier: Apache-2.0
// A night in minutes (./run soak).
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>
#include <string>

#include "tests/system/soak.hpp"

namespace {

using namespace cmm::test;

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
    SoakOptions options;
    const std::map<std::string, Wire> wires{{"tcp", Wire::tcp}, {"rtu", Wire::rtu}, {"line", Wire::line}};
    CLI::App app("Job after job on one simulated machine while faults strike.");
    app.add_option("--hours", options.hours, "of machine time")->check(CLI::PositiveNumber);
    app.add_option("--speed", options.speed, "times real time")->check(CLI::PositiveNumber);
    app.add_option("--fault-every-s", options.fault_every_s, "of machine time, on average")->check(CLI::PositiveNumber);
    app.add_option("--wire", options.wire, "tcp, rtu or line")->transform(CLI::CheckedTransformer(wires));
    app.add_option("--seed", options.seed, "of the faults and their instants");
    app.add_option("--out", options.watch_file, "CSV file for memory and open files, each second");
    CLI11_PARSE(app, argc, argv);
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
