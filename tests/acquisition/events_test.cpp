// SPDX-License-Identifier: Apache-2.0
#include "acquisition/events.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

namespace cmm::acquisition {
namespace {

TEST(EventHub, NumbersWithoutGapsInDeliveryOrder) {
    core::ManualClock clock;
    EventHub hub(clock);
    hub.continue_after(41);
    std::vector<Event> seen;
    hub.listen([&](const Event& event) { seen.push_back(event); });
    clock.advance(std::chrono::milliseconds(1500));
    hub.emit(EventKind::run_started, 0.25, R"("part":"rotor")");
    ASSERT_EQ(seen.size(), 1U);
    EXPECT_EQ(seen[0].seq, 42U);
    EXPECT_DOUBLE_EQ(seen[0].t_host_s, 1.5);
    constexpr int per_thread = 500;
    const auto emit_many = [&] {
        for (int i = 0; i < per_thread; ++i)
            hub.emit(EventKind::sample_batch, 0.0, {});
    };
    std::thread other(emit_many);
    emit_many();
    other.join();
    ASSERT_EQ(seen.size(), 1U + 2U * per_thread);
    for (std::size_t i = 0; i < seen.size(); ++i)
        ASSERT_EQ(seen[i].seq, 42 + i);
    EXPECT_EQ(hub.last_seq(), seen.back().seq);
}

TEST(EventHub, LinesAreJson) {
    const Event event{7, EventKind::section_final, 1.25, 2.5, R"("section":3,"closed":true)"};
    const auto json = nlohmann::json::parse(to_ndjson(event));
    EXPECT_EQ(json.at("seq"), 7);
    EXPECT_EQ(json.at("event"), "SectionFinal");
    EXPECT_EQ(json.at("t_machine_s"), 1.25);
    EXPECT_EQ(json.at("t_host_s"), 2.5);
    EXPECT_EQ(json.at("section"), 3);
    EXPECT_EQ(to_ndjson(event).find('\n'), std::string::npos);
    EXPECT_EQ(nlohmann::json::parse(to_ndjson({8, EventKind::hold, 0, 0, {}})).at("event"), "Hold");
}

TEST(EventHub, EveryKindHasItsOwnName) {
    std::vector<std::string_view> names;
    for (int kind = 0; kind <= static_cast<int>(EventKind::points_chosen); ++kind) {
        const auto name = to_string(static_cast<EventKind>(kind));
        EXPECT_EQ(std::count(names.begin(), names.end(), name), 0) << name;
        EXPECT_NE(name, "Unknown");
        names.push_back(name);
    }
}

}  // namespace
}  // namespace cmm::acquisition
