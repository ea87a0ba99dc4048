// SPDX-License-Identifier: Apache-2.0
// The real parts over several seeds and pitches: a table, nothing asserted. real_parts_sweep [seeds] [part]
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/system/real_parts_run.hpp"

int main(int argc, char** argv) {
    using namespace cmm::test;
    if (real_data_folder().empty()) {
        std::puts("no ../shared/data here");
        return 0;
    }
    const int seeds = argc > 1 ? std::atoi(argv[1]) : 6;
    const std::string only = argc > 2 ? argv[2] : "";
    const TemporaryFolder folder;
    for (auto part : real_parts(folder)) {
        if (!only.empty() && part.name != only) continue;
        const double pitch_mm = part.pitch_mm;
        for (const double factor : {1.0, 0.6}) {
            part.pitch_mm = factor * pitch_mm;
            for (const bool unknown : {false, true}) {
                for (int seed = 100; seed < 100 + seeds; ++seed) {
                    const auto run = run_real_part(part, unknown, seed);
                    std::printf("%-16s pitch %.2f %-8s seed %d: %s\n", part.name.c_str(), part.pitch_mm,
                                unknown ? "none" : "nominal", seed, run.text().c_str());
                    std::fflush(stdout);
                }
            }
        }
    }
    return 0;
}
