// SPDX-License-Identifier: Apache-2.0
#include "tests/system/resumable_run.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "acquisition/journal.hpp"
#include "tests/support/outputs.hpp"

namespace cmm::test {

std::vector<std::string> scan_command(const std::string& machine, const std::string& part, const std::string& out,
                                      bool resume) {
    std::vector<std::string> arguments{cmmlive(), "scan", "--machine", machine, "--part", part, "--out", out};
    if (resume) arguments.emplace_back("--resume");
    return arguments;
}

std::vector<std::string> scan_command(const SimulatedMachine& machine, const std::string& part, const std::string& out,
                                      bool resume) {
    return scan_command(machine.url(), part, out, resume);
}

std::uintmax_t log_size(const SimulatedMachine& machine) {
    std::error_code absent;
    const auto size = std::filesystem::file_size(machine.log(), absent);
    return absent ? 0 : size;
}

void expect_every_sample_once(const std::string& run_file, const std::string& log_file) {
    auto journal = acquisition::Journal::read(run_file);
    ASSERT_TRUE(journal) << journal.error().text();
    const auto samples = (*journal)->samples();
    ASSERT_TRUE(samples) << samples.error().text();
    const auto log = read_csv(log_file);
    ASSERT_FALSE(log.empty());
    const std::int64_t shift = (*journal)->header().sequence_shift;
    ASSERT_EQ(samples->size(), log.size());
    for (std::size_t i = 0; i < log.size(); ++i) {
        ASSERT_EQ((*samples)[i].sequence, i + 1);
        ASSERT_EQ(static_cast<std::int64_t>((*samples)[i].sequence) - shift, std::stoll(log[i].at("seq")));
        ASSERT_EQ((*samples)[i].counts[0], std::stoi(log[i].at("x_counts")));
        ASSERT_EQ((*samples)[i].counts[1], std::stoi(log[i].at("y_counts")));
        ASSERT_EQ((*samples)[i].counts[2], std::stoi(log[i].at("z_counts")));
    }
}

SeenState state_of(const SimulatedMachine& machine) {
    const auto doctor = run({cmmlive(), "doctor", "--machine", machine.url(), "--json"});
    const auto document = nlohmann::json::parse(doctor.out, nullptr, false);
    if (document.is_discarded() || !document.contains("machine")) return {};
    return {document["machine"]["state"], document["machine"]["fault"]};
}

}  // namespace cmm::test
