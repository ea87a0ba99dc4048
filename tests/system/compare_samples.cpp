// SPDX-License-Identifier: Apache-2.0
#include "tests/system/compare_samples.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>

#include "acquisition/journal.hpp"

namespace cmm::test {
namespace {

using Counts = std::array<std::int32_t, 3>;
using Starts = std::vector<std::vector<Counts>>;  // of the controller, with the counts of each

std::vector<std::string> fields_of(const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream in(line);
    for (std::string field; std::getline(in, field, ',');)
        fields.push_back(field);
    return fields;
}

/// Line by line: the log of a night has millions of them.
Starts read_log(const std::string& file) {
    std::ifstream in(file);
    std::string line, boot_id;
    std::getline(in, line);
    const auto names = fields_of(line);
    const auto column = [&](const char* name) {
        return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    };
    const std::size_t boot = column("boot_id"), x = column("x_counts"), y = column("y_counts"), z = column("z_counts");
    Starts starts;
    while (std::getline(in, line)) {
        const auto fields = fields_of(line);
        if (starts.empty() || fields.at(boot) != boot_id) starts.emplace_back();
        boot_id = fields.at(boot);
        starts.back().push_back({std::stoi(fields.at(x)), std::stoi(fields.at(y)), std::stoi(fields.at(z))});
    }
    return starts;
}

/// The counts of all runs, one after another; empty `wrong`: each run numbers its samples from 1 on.
struct Recorded {
    std::vector<Counts> counts;
    std::string wrong;
};
Recorded read_runs(const std::vector<std::string>& files) {
    Recorded recorded;
    for (const std::string& file : files) {
        const auto journal = acquisition::Journal::read(file);
        if (!journal) return {{}, journal.error().text()};
        const auto samples = (*journal)->samples();
        if (!samples) return {{}, samples.error().text()};
        for (std::size_t k = 0; k < samples->size(); ++k) {
            if ((*samples)[k].sequence != k + 1)
                return {{}, file + ": sequence " + std::to_string(k + 1) + " is not there"};
            recorded.counts.push_back((*samples)[k].counts);
        }
    }
    return recorded;
}

}  // namespace

std::string compare_samples(const std::vector<std::string>& run_files, const std::string& log_file) {
    const Recorded recorded = read_runs(run_files);
    if (!recorded.wrong.empty()) return recorded.wrong;
    const auto& samples = recorded.counts;
    const Starts starts = read_log(log_file);
    std::size_t at = 0;
    for (const auto& start : starts) {
        std::size_t k = 0;
        while (k < start.size() && at < samples.size() && samples[at] == start[k]) {
            ++k;
            ++at;
        }
        if (&start == &starts.back() && k < start.size()) {
            return "sample " + std::to_string(k + 1) + " of " + std::to_string(start.size()) +
                   " of the controller is not number " + std::to_string(at + 1) + " of " +
                   std::to_string(samples.size()) + " in the run files";
        }
    }
    if (at < samples.size()) return "the run files hold more samples than the controller recorded";
    return {};
}

}  // namespace cmm::test
