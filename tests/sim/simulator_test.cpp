// SPDX-License-Identifier: Apache-2.0
#include "sim/simulator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <sstream>

#include "core/text.hpp"
#include "sim/registers.hpp"
#include "tests/sim/temporary_file.hpp"
#include "tests/sim/wire_client.hpp"

namespace cmm::sim::test {
namespace {

constexpr const char* part_file = "config/parts/demo.toml";

SimulatorOptions demo_options() {
    SimulatorOptions options;
    options.part_file = part_file;
    options.machine_file = "config/machines/sim.toml";
    options.map_file = "config/maps/cmm-v1.toml";
    options.speed = 0.0;
    return options;
}

using Counts = std::array<std::int32_t, 3>;

/// Feeds the path and takes the samples until the path has ended, acknowledging everything at once.
std::map<std::uint32_t, Counts> scan(WireClient& host, const std::vector<PathPoint>& path) {
    std::map<std::uint32_t, Counts> taken;
    EXPECT_EQ(host.run(opcode::path_begin, {1}), 0);
    std::uint32_t sent = 0;
    const auto feed = [&] {
        const std::span<const PathPoint> window(path.data() + sent, std::min<std::size_t>(10, path.size() - sent));
        if (!window.empty() && host.send_window(1, sent, window) == 0)
            sent += static_cast<std::uint32_t>(window.size());
    };
    feed();
    host.start(opcode::scan, {1, 10000, 10000, 10000});
    std::uint32_t ack = 0;
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < deadline) {
        feed();
        const auto block = host.exchange(ack);
        const std::uint32_t first = get32(block, 3, true);
        for (std::uint32_t i = 0; i < block[7]; ++i)
            for (std::size_t axis = 0; axis < 3; ++axis)
                taken[first + i][axis] = static_cast<std::int32_t>(get32(block, 13 + 8 * i + 2 * axis, true));
        ack = first + block[7] - 1;
        if ((block[8] & 4) != 0 && (block[8] & 2) == 0 && sent == path.size()) return taken;
    }
    ADD_FAILURE() << "the path does not end";
    return taken;
}

TEST(Simulator, ScansABladeAndItsLogSaysWhatItSent) {
    const TemporaryFile log("");
    const auto part = load_part(part_file);
    ASSERT_TRUE(part) << part.error().text();
    const auto path = walk_around(*part->surface, 20.0, part->ball_radius_mm, 0.4, 10.0);
    ASSERT_GT(path.size(), 100U);
    SimulatorOptions options = demo_options();
    options.log_file = log.path();
    auto simulator = Simulator::start(options);
    ASSERT_TRUE(simulator) << simulator.error().text();
    WireClient host((*simulator)->port());
    host.prepare(part->ball_radius_mm);
    const Eigen::Vector3d above = path[0].position + 20.0 * path[0].normal;
    const auto count = [](double mm) { return static_cast<std::int32_t>(std::lround(mm * 1e4)); };
    ASSERT_EQ(host.run(opcode::move, {count(above.x()), count(above.y()), count(above.z()), 300000}), 0);
    const auto taken = scan(host, path);
    EXPECT_EQ(host.finish(), 0);
    (*simulator)->stop();
    (*simulator)->stop();
    ASSERT_EQ(taken.size(), path.size());

    std::istringstream rows(log.content());
    std::string row;
    std::getline(rows, row);
    std::size_t seen = 0;
    std::size_t warm = 0;
    while (std::getline(rows, row)) {
        const auto fields = core::split(row, ',');
        ASSERT_EQ(fields.size(), 14U);
        const auto field = [&](std::size_t i) { return core::parse_number(fields[i]).value(); };
        const auto sample = taken.find(static_cast<std::uint32_t>(field(1)));
        ASSERT_NE(sample, taken.end());
        const Eigen::Vector3d truth(field(8), field(9), field(10));
        EXPECT_NEAR(part->surface->nearest(truth, warm).distance_mm, part->ball_radius_mm, 1e-6);
        const double error_mm = (field(11) + field(12)) * 1e-3;
        const Eigen::Vector3d sent(sample->second[0] * 1e-4, sample->second[1] * 1e-4, sample->second[2] * 1e-4);
        EXPECT_NEAR((sent - truth).norm(), std::abs(error_mm), 1.5e-4);
        ++seen;
    }
    EXPECT_EQ(seen, path.size());
}

TEST(Simulator, EachStartHasItsOwnBootId) {
    std::vector<std::uint16_t> ids;
    for (int i = 0; i < 2; ++i) {
        const auto simulator = Simulator::start(demo_options());
        ASSERT_TRUE(simulator) << simulator.error().text();
        ids.push_back(WireClient((*simulator)->port()).read(44, 1)[0]);
        EXPECT_EQ((*simulator)->url(), "modbus+tcp://127.0.0.1:" + std::to_string((*simulator)->port()) + "?unit=1");
    }
    EXPECT_NE(ids[0], ids[1]);
}

TEST(Simulator, WhatCannotStartSaysWhy) {
    const auto expect_refused = [](const SimulatorOptions& options, const std::string& why) {
        const auto simulator = Simulator::start(options);
        ASSERT_FALSE(simulator);
        EXPECT_NE(simulator.error().text().find(why), std::string::npos) << simulator.error().text();
    };
    SimulatorOptions options = demo_options();
    options.part_file = "no-such-part.toml";
    expect_refused(options, "no-such-part.toml");
    options = demo_options();
    options.machine_file = "no-such-machine.toml";
    expect_refused(options, "no-such-machine.toml");
    options = demo_options();
    options.map_file = "no-such-map.toml";
    expect_refused(options, "no-such-map.toml");
    options = demo_options();
    options.log_file = "no/such/folder/log.csv";
    expect_refused(options, "log.csv");
    options = demo_options();
    options.speed = -1.0;
    expect_refused(options, "speed");
}

}  // namespace
}  // namespace cmm::sim::test
