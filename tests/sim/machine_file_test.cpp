// SPDX-License-Identifier: Apache-2.0
#include "sim/machine_file.hpp"

#include <gtest/gtest.h>

#include "sim/register_map.hpp"
#include "tests/sim/temporary_file.hpp"

namespace cmm::sim::test {
namespace {

TEST(MachineFile, TheRepositorysMachineReads) {
    const auto machine = load_machine_settings("config/machines/sim.toml");
    ASSERT_TRUE(machine) << machine.error().text();
    EXPECT_EQ(machine->model, "cmmlive sim");
    EXPECT_DOUBLE_EQ(machine->lsb_mm, 1e-4);
    EXPECT_EQ(machine->sample_rate_hz, 1000);
    EXPECT_EQ(machine->fifo_depth, 8192U);
}

TEST(MachineFile, DefaultsHoldWithoutATable) {
    const TemporaryFile file("[link]\nurl = \"x\"\n");
    const auto machine = load_machine_settings(file.path());
    ASSERT_TRUE(machine) << machine.error().text();
    EXPECT_EQ(machine->watchdog_ms, 500);
}

void expect_refused(const std::string& text, const std::string& why) {
    const TemporaryFile file(text);
    const auto machine = load_machine_settings(file.path());
    ASSERT_FALSE(machine) << text;
    EXPECT_NE(machine.error().text().find(why), std::string::npos) << machine.error().text();
}

TEST(MachineFile, WhatDoesNotHoldIsNamedWithItsPlace) {
    expect_refused("[controller]\nsample_rate_hz = 4001\n", ":2:");
    expect_refused("[controller]\nserial = \"12345678901234567\"\n", "16 characters");
    expect_refused("[controller]\nmodel = \"m\\u00e9t\"\n", "ASCII");
    expect_refused("[controller]\nhome_mm = [1, 2]\n", "three numbers");
    expect_refused("[controller]\nhome_mm = [0, 0, 701]\n", "outside the travel");
    expect_refused("[controller]\nlimit_min_mm = [0, 0, 700]\n", "above limit_min_mm");
    expect_refused("[controller]\nlsb_nm = 1\nlimit_max_mm = [3000, 500, 700]\n", "32-bit");
    expect_refused("[controller]\nwatchdog_s = 1\n", "watchdog_ms");
}

TEST(RegisterMap, TheRepositorysMapIsTheOneOfTheDocument) {
    const auto map = load_register_map("config/maps/cmm-v1.toml");
    ASSERT_TRUE(map) << map.error().text();
    EXPECT_EQ(map->status.address, 64U);
    EXPECT_EQ(map->status.crc, 36U);
    EXPECT_EQ(map->path_window, 10U);
    EXPECT_EQ(map->fifo_window, 14U);
    EXPECT_EQ(map->exchange.length, 5U);
    EXPECT_TRUE(map->big_words);
}

void expect_map_refused(const std::string& from, const std::string& to, const std::string& why) {
    std::string text = core::read_file("config/maps/cmm-v1.toml").value();
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const TemporaryFile file(text);
    const auto map = load_register_map(file.path());
    ASSERT_FALSE(map) << to;
    EXPECT_NE(map.error().text().find(why), std::string::npos) << map.error().text();
}

TEST(RegisterMap, BrokenMapsAreRefused) {
    expect_map_refused("boot_id = 44", "boot_id = 46", "does not fit");
    expect_map_refused("address = 64\n", "address = 40\n", "overlap");
    expect_map_refused("fifo_level = 30", "fifo_levl = 30", "fifo_level");
    expect_map_refused("point_length = 11", "point_length = 10", "must be 11");
    expect_map_refused("point_length = 8", "point_length = 7", "must be 8");
    expect_map_refused("state = 0", "state = { at = 0, bit = 12, bits = 5 }", "bits");
    expect_map_refused("state = 0", "state = { at = 37 }", "does not fit");
    expect_map_refused("header = 6", "header = 4", "too short");
    expect_map_refused("word_order = \"big\"", "word_order = \"middle\"", "big");
    EXPECT_FALSE(load_register_map("no/such/map.toml"));
}

}  // namespace
}  // namespace cmm::sim::test
