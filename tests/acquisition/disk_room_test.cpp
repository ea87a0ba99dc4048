// SPDX-License-Identifier: Apache-2.0
#include "acquisition/disk_room.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/acquisition/temp_folder.hpp"

namespace cmm::acquisition {
namespace {

TEST(DiskRoom, IsAskedForAndGivenBack) {
    const TempFolder folder;
    EXPECT_TRUE(disk_has_room(folder.path("run.cmmrun"), 4096));
    EXPECT_FALSE(disk_has_room(folder.path("run.cmmrun"), std::int64_t{1} << 60U));
    EXPECT_TRUE(std::filesystem::is_empty(std::filesystem::path(folder.path("run.cmmrun")).parent_path()));
}

TEST(DiskRoom, ThereIsNoneWhereNothingCanBeWritten) {
    const TempFolder folder;
    EXPECT_FALSE(disk_has_room(folder.path("none/run.cmmrun"), 4096));
    EXPECT_FALSE(disk_has_room("/proc/run.cmmrun", 4096));
}

}  // namespace
}  // namespace cmm::acquisition
