// SPDX-License-Identifier: Apache-2.0
#include "acquisition/workers.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <future>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "drivers/until_durable.hpp"

namespace cmm::acquisition {

/// Durable at the third look, or failing there.
struct SlowKeeper {
    bool fails = false;
    int looks = 0;
    core::Result<bool> hasten() {
        if (++looks < 3) return false;
        if (fails) return core::fail(core::ErrorCode::journal_full, "the disk is full");
        return true;
    }
};

namespace {

namespace asio = boost::asio;

struct WorkersTest : ::testing::Test {
    asio::io_context loop;
    Workers workers{1};
    std::promise<void> gate;
    std::shared_future<void> opened = gate.get_future().share();
    std::vector<std::string> ended;

    asio::awaitable<void> note(std::string name) {
        auto work = [name] { return name; };
        ended.push_back(co_await workers.run(std::move(work)));
    }
    asio::awaitable<void> note_long(std::string name) {
        auto work = [this, name] {
            opened.wait();
            return name;
        };
        ended.push_back(co_await workers.run_long(std::move(work)));
    }
};

TEST_F(WorkersTest, AnswersOnTheLoopOfTheOneWhoAsked) {
    std::thread::id worked, answered;
    auto ask = [&]() -> asio::awaitable<void> {
        auto work = [&] {
            worked = std::this_thread::get_id();
            return 1;
        };
        EXPECT_EQ(co_await workers.run(std::move(work)), 1);
        answered = std::this_thread::get_id();
    };
    asio::co_spawn(loop, ask(), asio::detached);
    loop.run();
    EXPECT_EQ(answered, std::this_thread::get_id());
    EXPECT_NE(worked, answered);
}

TEST_F(WorkersTest, AnAnswerGoesOutBeforeTheNextWorkIsBegun) {
    std::promise<void> first_answered;
    auto seen = first_answered.get_future().share();
    auto first = [&]() -> asio::awaitable<void> {
        auto work = [] { return 1; };
        co_await workers.run(std::move(work));
        first_answered.set_value();
    };
    bool in_time = false;
    auto second = [&]() -> asio::awaitable<void> {
        auto work = [&] { return seen.wait_for(std::chrono::seconds(20)) == std::future_status::ready; };
        in_time = co_await workers.run(std::move(work));
    };
    asio::co_spawn(loop, first(), asio::detached);
    asio::co_spawn(loop, second(), asio::detached);
    loop.run();
    EXPECT_TRUE(in_time);
}

TEST_F(WorkersTest, ALongWorkHoldsUpNoShortOne) {
    asio::co_spawn(loop, note_long("long"), asio::detached);
    auto after = [this]() -> asio::awaitable<void> {
        co_await note("short");
        gate.set_value();
    };
    asio::co_spawn(loop, after(), asio::detached);
    loop.run();
    EXPECT_EQ(ended, (std::vector<std::string>{"short", "long"}));
}

TEST_F(WorkersTest, WhoStaysAwakeHoldsUpNobody) {
    const auto stay = [this](std::promise<void>& begun) {
        workers.post([this, &begun] {
            begun.set_value();
            workers.stay_awake(std::chrono::hours(1));
        });
        begun.get_future().wait();
    };
    std::promise<void> first, second, posted;
    stay(first);
    workers.post([&] { posted.set_value(); });
    EXPECT_EQ(posted.get_future().wait_for(std::chrono::seconds(20)), std::future_status::ready);
    stay(second);
    asio::co_spawn(loop, note("awaited"), asio::detached);
    loop.run();
    EXPECT_EQ(ended, std::vector<std::string>{"awaited"});
}

TEST_F(WorkersTest, WhoStaysAwakeGoesToSleepAgain) {
    std::promise<bool> slept;
    workers.post([&] {
        const auto begun = std::chrono::steady_clock::now();
        workers.stay_awake(std::chrono::milliseconds(20));
        slept.set_value(std::chrono::steady_clock::now() - begun >= std::chrono::milliseconds(20));
    });
    EXPECT_TRUE(slept.get_future().get());
}

TEST_F(WorkersTest, WhatIsThrownComesOutWhereItIsAwaited) {
    std::string what;
    auto ask = [&]() -> asio::awaitable<void> {
        auto work = []() -> int { throw std::runtime_error("no room"); };
        try {
            co_await workers.run(std::move(work));
        } catch (const std::runtime_error& error) {
            what = error.what();
        }
    };
    asio::co_spawn(loop, ask(), asio::detached);
    loop.run();
    EXPECT_EQ(what, "no room");
}

TEST(UntilDurable, LooksAgainWhileTheLoopGoesOn) {
    for (const bool fails : {false, true}) {
        asio::io_context loop;
        SlowKeeper keeper{fails};
        core::Status status;
        int others = 0;
        auto wait = [&]() -> asio::awaitable<void> { status = co_await drivers::until_durable(keeper); };
        asio::co_spawn(loop, wait(), asio::detached);
        asio::post(loop, [&others] { ++others; });
        loop.run();
        EXPECT_EQ(keeper.looks, 3);
        EXPECT_EQ(others, 1);
        EXPECT_EQ(status.has_value(), !fails);
        if (fails) {
            EXPECT_EQ(status.error().code, core::ErrorCode::journal_full);
        }
    }
}

}  // namespace
}  // namespace cmm::acquisition
