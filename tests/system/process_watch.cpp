// SPDX-License-Identifier: Apache-2.0
#include "tests/system/process_watch.hpp"

#include <filesystem>
#include <fstream>
#include <string>

namespace cmm::test {

Holdings holdings_of(pid_t process, double hours) {
    Holdings held{hours, 0.0, 0};
    const std::string folder = "/proc/" + std::to_string(process);
    std::ifstream status(folder + "/status");
    for (std::string word; status >> word;)
        if (word == "VmRSS:") status >> held.memory_kb;
    std::error_code gone;
    for (auto entry = std::filesystem::directory_iterator(folder + "/fd", gone);
         !gone && entry != std::filesystem::directory_iterator(); entry.increment(gone))
        ++held.files;
    return held;
}

double memory_slope(const std::vector<Holdings>& seen) {
    const std::size_t first = seen.size() / 10;
    const auto n = static_cast<double>(seen.size() - first);
    if (n < 3) return 0.0;
    double mean_h = 0.0, mean_kb = 0.0, hh = 0.0, hk = 0.0;
    for (std::size_t k = first; k < seen.size(); ++k) {
        mean_h += seen[k].hours / n;
        mean_kb += seen[k].memory_kb / n;
    }
    for (std::size_t k = first; k < seen.size(); ++k) {
        hh += (seen[k].hours - mean_h) * (seen[k].hours - mean_h);
        hk += (seen[k].hours - mean_h) * (seen[k].memory_kb - mean_kb);
    }
    return hh > 0.0 ? hk / hh : 0.0;
}

}  // namespace cmm::test
