// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "bench/bench.hpp"
#include "bench/peer_table.hpp"
#include "support/compared_methods.hpp"

namespace cmm::bench {

/// 25 sections of 600 points, ball 1 mm; with 1 um of noise and 1.5 % bad points, and without either.
void bench_compensation_methods() {
    using namespace fitting;
    for (const auto family : families::all_families)
        for (const bool noisy : {true, false}) {
            const families::ComparedBlade blade(family, 1, 25, noisy);
            std::printf("%s%s: contours by each method, rms and max of the error\n", blade.name().c_str(),
                        noisy ? "" : " without noise");
            for (const auto name : compensation_method_names()) {
                const auto errors = blade.errors(*compensation_method_from(name));
                std::printf("  %-16.*s sides %s; edges %s; contacts set aside %zu, sections refused %zu of %zu\n",
                            static_cast<int>(name.size()), name.data(), rms_and_max(errors.sides).c_str(),
                            rms_and_max(errors.edges).c_str(), errors.set_aside, errors.refused, errors.sections);
            }
            std::fflush(stdout);
        }
}

}  // namespace cmm::bench
