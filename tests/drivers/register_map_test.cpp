// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/register_map.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/text.hpp"

namespace cmm::drivers::modbus {
namespace {

std::string map_text() {
    return core::read_file("config/maps/cmm-v1.toml").value_or("");
}

core::Result<RegisterMap> load_text(const std::string& text) {
    const auto path = std::filesystem::temp_directory_path() / (std::to_string(::getpid()) + "-map.toml");
    std::ofstream(path) << text;
    auto map = RegisterMap::load(path.string());
    std::filesystem::remove(path);
    return map;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(RegisterMap, TheShippedFileIsTheBuiltInVersion) {
    const auto map = RegisterMap::load("config/maps/cmm-v1.toml");
    ASSERT_TRUE(map) << map.error().text();
    const RegisterMap built_in;
    EXPECT_EQ(map->name, built_in.name);
    EXPECT_EQ(map->version, built_in.version);
    EXPECT_EQ(map->high_word_first, built_in.high_word_first);
    EXPECT_EQ(std::memcmp(&map->identity, &built_in.identity, sizeof built_in.identity), 0);
    EXPECT_EQ(std::memcmp(&map->status, &built_in.status, sizeof built_in.status), 0);
    EXPECT_EQ(std::memcmp(&map->command, &built_in.command, sizeof built_in.command), 0);
    EXPECT_EQ(map->stop.address, built_in.stop.address);
    EXPECT_EQ(std::memcmp(&map->path, &built_in.path, sizeof built_in.path), 0);
    EXPECT_EQ(std::memcmp(&map->exchange, &built_in.exchange, sizeof built_in.exchange), 0);
    EXPECT_EQ(std::memcmp(&map->fifo, &built_in.fifo, sizeof built_in.fifo), 0);
    EXPECT_DOUBLE_EQ(map->scale.speed_mm_s, built_in.scale.speed_mm_s);
    EXPECT_EQ(map->scale.count_mm, 0.0);
}

TEST(RegisterMap, ErrorsNameKeyAndPlace) {
    const auto expect_error = [](const std::string& text, const std::string& part) {
        const auto map = load_text(text);
        ASSERT_FALSE(map) << part;
        EXPECT_EQ(map.error().code, core::ErrorCode::config_invalid);
        EXPECT_NE(map.error().message.find(part), std::string::npos) << map.error().message;
        EXPECT_NE(map.error().message.find("-map.toml:"), std::string::npos) << map.error().message;
    };
    expect_error(replaced(map_text(), "boot_id = 44", ""), "identity.boot_id is missing");
    expect_error(replaced(map_text(), "boot_id = 44", "boot_id = 46"), "reaches beyond");
    expect_error(replaced(map_text(), "values = 7", "values = \"7\""), "whole number");
    expect_error(replaced(map_text(), "heartbeat = 1", "hartbeat = 1"), "hartbeat");
    expect_error(replaced(map_text(), "state = 0", "state = { at = 0, bit = 12, bits = 5 }"), "bits");
    expect_error(replaced(map_text(), "state = 0", "state = { at = 37 }"), "reaches beyond");
    expect_error(map_text() + "[fifo.point]\nposition = 3\n", "behind the end of the point");
    expect_error(replaced(map_text(), "length = 125", "length = 126"), "from 0 to 125");
    expect_error(replaced(map_text(), "word_order = \"big\"", "word_order = \"mixed\""), "little");
    const auto broken = load_text("[map\n");
    ASSERT_FALSE(broken);
    EXPECT_EQ(broken.error().code, core::ErrorCode::config_syntax);
    EXPECT_EQ(RegisterMap::load("no/such/map.toml").error().code, core::ErrorCode::input_missing);
}

TEST(RegisterMap, WordOrderIsData) {
    RegisterMap map;
    std::array<std::uint16_t, 3> block{0x1234, 0x5678, 0x9ABC};
    EXPECT_EQ(map.u32(block, 0), 0x12345678U);
    EXPECT_EQ(map.u48(block, 0), 0x123456789ABC);
    map.high_word_first = false;
    EXPECT_EQ(map.u32(block, 0), 0x56781234U);
    EXPECT_EQ(map.u48(block, 0), 0x9ABC56781234);
    for (const bool order : {false, true}) {
        map.high_word_first = order;
        map.put_i32(block, 1, -2);
        EXPECT_EQ(map.i32(block, 1), -2);
    }
}

TEST(RegisterMap, PartsOfARegisterAreData) {
    const auto map = RegisterMap::load("config/maps/plc-le.toml");
    ASSERT_TRUE(map) << map.error().text();
    std::array<std::uint16_t, 32> status{};
    status[0] = 0x0534;  // command done (2), flags 0x13, state 4
    status[1] = 0x0D0E;
    EXPECT_EQ(map->value(status, map->status.state), 4U);
    EXPECT_EQ(map->value(status, map->status.flags), 0x13U);
    EXPECT_EQ(map->value(status, map->status.command_state), 2U);
    EXPECT_EQ(map->value(status, map->status.fault), 14U);
    EXPECT_EQ(map->value(status, map->status.result), 13U);
    const Field narrow{0, 1, 0, 16};
    EXPECT_EQ(RegisterMap::unwrapped(narrow, 10, 0), 10U);
    EXPECT_EQ(RegisterMap::unwrapped(narrow, 10, 65530), 65546U);
    EXPECT_EQ(RegisterMap::unwrapped(narrow, 65530, 65546), 65530U) << "an older count";
    EXPECT_EQ(RegisterMap::unwrapped(narrow, 3, 200'000), 196'611U);
    EXPECT_EQ(RegisterMap::unwrapped(Field{0, 2, 0, 32}, 7, 200'000), 7U);
}

TEST(Crc16, MatchesPublishedValues) {
    // "123456789" is the check string of CRC catalogues: CRC-16/MODBUS gives 0x4B37. As registers it needs an even
    // length, hence the Modbus frame of the specification's example too: 02 07 -> 0x1241 (sent as 41 12).
    const std::array<std::uint16_t, 1> frame{0x0207};
    EXPECT_EQ(crc16(frame, 99), 0x1241);
    const std::array<std::uint16_t, 3> with_gap{0x0207, 0xFFFF, 0x0000};
    EXPECT_EQ(crc16(std::span(with_gap).first(2), 1), 0x1241) << "the CRC register itself is left out";
}

}  // namespace
}  // namespace cmm::drivers::modbus
