// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "tests/acquisition/session_fixture.hpp"
#include "tests/acquisition/temp_folder.hpp"

namespace cmm::web::test {

/// A folder of runs with one of them, "first": two sections, the second not finished, and events 1, 2 and 5.
struct RecordedRun {
    acquisition::SessionPart job;
    acquisition::TempFolder runs;
    std::string folder = runs.path("first");
    std::size_t points = 0;  ///< of the first section

    explicit RecordedRun(const std::string& part_text = acquisition::session_part_text()) : job(part_text) {
        std::filesystem::create_directories(folder);
        auto journal = acquisition::Journal::create(folder + "/run.cmmrun", acquisition::session_header(job)).value();
        points = job.plan.paths[0].points.size();
        scan(*journal, 0, points, 1);
        scan(*journal, 1, 40, points + 1);
        for (const int seq : {1, 2, 5})
            EXPECT_TRUE(
                journal->add_event(static_cast<std::uint64_t>(seq), "Hold", "{\"seq\":" + std::to_string(seq) + "}"));
        EXPECT_TRUE(journal->finish_path(1));
        EXPECT_TRUE(journal->flush());
    }

  private:
    void scan(acquisition::Journal& journal, std::size_t section, std::size_t count, std::uint64_t first) const {
        const auto path = static_cast<std::uint16_t>(section + 1);
        auto planned = job.plan.paths[section];
        planned.points.resize(count);
        EXPECT_TRUE(journal.begin_path({path, section, 0, false}));
        EXPECT_TRUE(journal.append(acquisition::samples_of(planned, path, first)));
    }
};

}  // namespace cmm::web::test
