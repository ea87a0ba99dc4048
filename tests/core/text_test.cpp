// SPDX-License-Identifier: Apache-2.0
#include "core/text.hpp"

#include <gtest/gtest.h>

#include <array>
#include <clocale>
#include <filesystem>

namespace cmm::core {
namespace {

TEST(Text, NumbersAreWholeAndFinite) {
    EXPECT_EQ(parse_number(" 1.5 "), 1.5);
    EXPECT_EQ(parse_number("+2"), 2.0);
    EXPECT_EQ(parse_number("-1e-3"), -1e-3);
    for (const char* bad : {"", " ", "abc", "1.5x", "nan", "inf", "1,5", "--1", "+", "0x10", "1e999"}) {
        EXPECT_FALSE(parse_number(bad)) << bad;
    }
}

TEST(Text, FixedHasNoNegativeZero) {
    EXPECT_EQ(fixed(-0.00001, 3), "0.000");
    EXPECT_EQ(fixed(-0.0006, 3), "-0.001");
    EXPECT_EQ(fixed(1e300, 0).size(), 301U);
    EXPECT_EQ(length_text(0.0032), "3.2 um");
    EXPECT_EQ(length_text(12.3456), "12.346 mm");
}

TEST(Text, SplitTrimsFields) {
    EXPECT_EQ(split("a, b ,,c", ','), (std::vector<std::string_view>{"a", "b", "", "c"}));
    EXPECT_EQ(split("  1\t 2  3 ", ' '), (std::vector<std::string_view>{"1", "2", "3"}));
    EXPECT_TRUE(split("   ", ' ').empty());
    EXPECT_EQ(split("", ',').size(), 1U);
}

TEST(Text, SmallLettersAreThoseOfAsciiAlone) {
    EXPECT_EQ(in_small_letters("MAX_Inscribed-9"), "max_inscribed-9");
    EXPECT_EQ(in_small_letters("\xc3\x84Z"), "\xc3\x84z") << "bytes of other alphabets stay";
}

TEST(Text, SuggestsTheNearestWordOnly) {
    constexpr std::array<std::string_view, 3> words{"pitch_mm", "edge_density", "max_speed_mm_s"};
    EXPECT_EQ(nearest_word("pich_mm", words), "pitch_mm");
    EXPECT_EQ(nearest_word("edge_densitty", words), "edge_density");
    EXPECT_FALSE(nearest_word("colour", words));
}

TEST(Text, FilesGoOutWholeAndComeBack) {
    const auto folder = std::filesystem::temp_directory_path() / ("cmm_text_test_" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder);
    const std::string path = folder / "a.txt";
    ASSERT_TRUE(write_file(path, "one\n"));
    ASSERT_TRUE(write_file(path, ""));
    EXPECT_EQ(read_file(path).value(), "");
    ASSERT_TRUE(write_file(path, std::string("a\0b", 3)));
    EXPECT_EQ(read_file(path).value(), std::string("a\0b", 3));
    EXPECT_FALSE(std::filesystem::exists(path + ".part"));
    std::filesystem::remove_all(folder);
    EXPECT_EQ(read_file(path).error().code, ErrorCode::input_missing);
    EXPECT_EQ(write_file(path, "x").error().code, ErrorCode::journal_io);
}

TEST(Text, AFullDiskIsSaidSo) {
    // /dev/full refuses every write with ENOSPC; the rename is never reached because the write fails first.
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    const auto folder = std::filesystem::temp_directory_path() / ("cmm_text_full_" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder);
    std::filesystem::create_symlink("/dev/full", folder / "a.txt.part");
    const auto status = write_file(folder / "a.txt", "x");
    std::filesystem::remove_all(folder);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::journal_full);
}

}  // namespace
}  // namespace cmm::core
