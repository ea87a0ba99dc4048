// SPDX-License-Identifier: Apache-2.0
#include "tests/system/compare_samples.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "acquisition/journal.hpp"

namespace cmm::test {
namespace {

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

std::size_t common(const std::vector<Counts>& recorded, std::size_t at, const std::vector<Counts>& start) {
    const auto from = recorded.begin() + static_cast<std::ptrdiff_t>(at);
    return static_cast<std::size_t>(std::mismatch(from, recorded.end(), start.begin(), start.end()).first - from);
}

/// Whether what was recorded from `at` on is the first part of each start but the last, and the whole of the last.
/// Where one ends is not always plain: a point that is measured again may have the counts that were lost.
bool is_all(const std::vector<Counts>& recorded, std::size_t at, const Starts& starts, std::size_t k) {
    const std::size_t most = common(recorded, at, starts[k]);
    if (k + 1 == starts.size()) return most == starts[k].size() && at + most == recorded.size();
    for (std::size_t taken = most + 1; taken-- > 0;)
        if (is_all(recorded, at + taken, starts, k + 1)) return true;
    return false;
}

}  // namespace

std::string compare_counts(const std::vector<Counts>& recorded, const Starts& starts) {
    if (starts.empty()) return recorded.empty() ? "" : "the controller recorded nothing";
    if (is_all(recorded, 0, starts, 0)) return {};
    std::size_t at = 0, last = 0;
    for (const auto& start : starts)
        at += last = common(recorded, at, start);
    if (last == starts.back().size()) return "the run files hold more samples than the controller recorded";
    return "sample " + std::to_string(last + 1) + " of " + std::to_string(starts.back().size()) +
           " of the controller is not number " + std::to_string(at + 1) + " of " + std::to_string(recorded.size()) +
           " in the run files";
}

std::string compare_samples(const std::vector<std::string>& run_files, const std::string& log_file) {
    const Recorded recorded = read_runs(run_files);
    return recorded.wrong.empty() ? compare_counts(recorded.counts, read_log(log_file)) : recorded.wrong;
}

}  // namespace cmm::test
