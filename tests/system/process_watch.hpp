// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <vector>

namespace cmm::test {

/// What the kernel says a process holds.
struct Holdings {
    double hours = 0.0;  ///< when, of any clock that the user of this keeps
    double memory_kb = 0.0;
    int files = 0;
};

/// Resident memory and open files of a process now; nothing (0) when it is gone.
Holdings holdings_of(pid_t process, double hours);

/// Least squares: kilobytes an hour, of all after the first tenth (warm-up). Zero below three values.
double memory_slope(const std::vector<Holdings>& seen);

}  // namespace cmm::test
