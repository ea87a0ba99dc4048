// SPDX-License-Identifier: Apache-2.0
#include "acquisition/disk_room.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <thread>

#include "tests/acquisition/temp_folder.hpp"

namespace cmm::acquisition {
namespace {

bool eventually(const std::function<bool()>& holds) {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!holds()) {
        if (std::chrono::steady_clock::now() > give_up) return false;
        std::this_thread::yield();
    }
    return true;
}

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

/// A disk that answers when the test says so; the thread that asks it may outlive the test.
struct DyingDisk {
    std::promise<bool> answer;
    std::shared_future<bool> when = answer.get_future().share();
    std::shared_ptr<std::atomic<int>> asked = std::make_shared<std::atomic<int>>(0);
    std::function<bool()> question() const {
        return [when = when, asked = asked] {
            ++*asked;
            return when.get();
        };
    }
};

TEST(DiskQuestion, IsAnsweredOnce) {
    for (const bool yes : {true, false}) {
        DiskQuestion disk;
        EXPECT_FALSE(disk.answer());
        disk.ask([yes] { return yes; });
        std::optional<bool> answer;
        EXPECT_TRUE(eventually([&] { return (answer = disk.answer()).has_value(); }));
        EXPECT_EQ(answer, yes);
        EXPECT_FALSE(disk.answer());
    }
}

TEST(DiskQuestion, IsNotAskedAgainWhileItIsOpen) {
    DyingDisk dying;
    DiskQuestion disk;
    for (int k = 0; k < 5; ++k) {
        disk.ask(dying.question());
        EXPECT_FALSE(disk.answer());
    }
    dying.answer.set_value(true);
    EXPECT_TRUE(eventually([&] { return disk.answer().has_value(); }));
    EXPECT_EQ(*dying.asked, 1);
}

TEST(DiskQuestion, ThatStaysOpenHoldsNothingUp) {
    DyingDisk dying;
    { DiskQuestion().ask(dying.question()); }
    EXPECT_TRUE(eventually([&] { return *dying.asked == 1; }));
    dying.answer.set_value(false);
}

}  // namespace
}  // namespace cmm::acquisition
