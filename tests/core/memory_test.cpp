// SPDX-License-Identifier: Apache-2.0
#include "core/memory.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstddef>
#include <thread>
#include <vector>

namespace cmm::core {
namespace {

long page_faults() {
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    return used.ru_minflt;
}

constexpr int rounds = 100;
constexpr std::size_t doubles = 1U << 17U;  // 1 MB: 256 pages

/// Of one thread that asks for the same memory again and again, after the first time.
long faults_of_rounds() {
    long before = 0;
    for (int round = 0; round <= rounds; ++round) {
        const std::vector<double> some(doubles, 1.0);
        if (round == 0) before = page_faults();
    }
    return page_faults() - before;
}

TEST(Memory, FreedMemoryIsUsedAgainWithoutFaults) {
    if (!keep_freed_memory()) GTEST_SKIP() << "not glibc's allocator";
    EXPECT_LT(faults_of_rounds(), rounds);  // of 256 pages each
    long of_thread = 0;
    std::thread([&of_thread] { of_thread = faults_of_rounds(); }).join();
    EXPECT_LT(of_thread, rounds);
}

}  // namespace
}  // namespace cmm::core
