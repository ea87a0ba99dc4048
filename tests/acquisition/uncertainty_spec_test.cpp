// SPDX-License-Identifier: Apache-2.0
#include "acquisition/uncertainty_spec.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "acquisition/part_file.hpp"
#include "tests/acquisition/test_blade.hpp"

namespace cmm::acquisition {
namespace {

const std::string plain = none_part + "[uncertainty]\n";

UncertaintySpec read(const std::string& keys) {
    const auto part = parse_part_file(plain + keys, "p.toml");
    EXPECT_TRUE(part) << part.error().text();
    return part ? part->uncertainty : UncertaintySpec{};
}

std::string complaint(const std::string& keys) {
    const auto part = parse_part_file(plain + keys, "dir/p.toml");
    return part ? "" : part.error().message;
}

TEST(UncertaintySpec, LargestErrorsBecomeStandardUncertainties) {
    const auto spec = read(
        "length_um = 1.9\nlength_k_mm_per_um = 300\nprobing_form_um = 1.8\nprobing_size_um = 1.2\n"
        "ball_radius_standard_um = 0.3\n");
    const auto errors = spec.errors();
    const double root3 = std::sqrt(3.0);
    EXPECT_NEAR(errors.constant_mm, 1.9e-3 / root3, 1e-12);
    EXPECT_NEAR(errors.per_mm, 1e-3 / 300.0 / root3, 1e-15);
    EXPECT_NEAR(errors.form_mm, 0.9e-3 / root3, 1e-12) << "half of a range";
    EXPECT_NEAR(errors.ball_mm, std::hypot(0.3e-3, 0.6e-3 / root3), 1e-12) << "half of a diameter, and the radius' own";
    EXPECT_EQ(errors.expansion, 0.0);
    EXPECT_FALSE(read("").errors().any());
}

TEST(UncertaintySpec, TheTemperatureMakesAKnownErrorAndAnUnknownOne) {
    const std::string warm =
        "part_temperature_c = 23\ntemperature_standard_k = 0.4\nexpansion_um_m_k = 11.5\n"
        "expansion_standard_um_m_k = 0.6\n";
    const auto none = read(warm), applied = read(warm + "expansion_correction = \"applied\"\n"),
               by_machine = read(warm + "expansion_correction = \"by_machine\"\n");
    const double growth = 3.0 * 11.5e-6, standard = std::hypot(0.4 * 11.5e-6, 3.0 * 0.6e-6);
    EXPECT_NEAR(none.growth(), growth, 1e-18);
    EXPECT_NEAR(none.errors().known_expansion, growth, 1e-18);
    for (const auto& spec : {none, applied, by_machine})
        EXPECT_NEAR(spec.errors().expansion, standard, 1e-18);
    EXPECT_EQ(applied.errors().known_expansion, 0.0);
    EXPECT_EQ(by_machine.errors().known_expansion, 0.0);
    // At 20 degrees, known to a tenth.
    const auto cool = read("temperature_standard_k = 0.1\nexpansion_um_m_k = 23\n");
    EXPECT_NEAR(cool.errors().expansion, 2.3e-6, 1e-18);
    EXPECT_EQ(cool.errors().known_expansion, 0.0);
}

TEST(UncertaintySpec, WhatThePartFileStatesGoesBeforeTheMachinesFigures) {
    auto spec = read("length_um = 1.0\n");
    spec.machine.length_mm = 5e-3;
    spec.machine.probing_form_mm = 2e-3;
    EXPECT_NEAR(*spec.figures().length_mm, 1e-3, 1e-15);
    EXPECT_NEAR(*spec.figures().probing_form_mm, 2e-3, 1e-15);
    EXPECT_FALSE(spec.figures().length_share);
    EXPECT_NEAR(*read("length_um = 0\n").figures().length_mm, 0.0, 0.0) << "none, said by the part file";
}

TEST(UncertaintySpec, MistakesAreNamedWhereTheyStand) {
    EXPECT_EQ(complaint("lenght_um = 1\n"),
              "dir/p.toml:9:1: unknown key uncertainty.lenght_um; did you mean \"length_um\"?");
    EXPECT_EQ(complaint("length_um = -1\n").rfind("dir/p.toml:9:1: uncertainty.length_um", 0), 0U);
    EXPECT_NE(complaint("length_k_mm_per_um = 0\n"), "");
    EXPECT_NE(complaint("part_temperature_c = 22\n").find("expansion_um_m_k is missing"), std::string::npos);
    EXPECT_NE(complaint("expansion_um_m_k = 11\n").find("needs part_temperature_c"), std::string::npos);
    EXPECT_NE(complaint("temperature_standard_k = 1\nexpansion_um_m_k = 11\nexpansion_correction = \"applied\"\n")
                  .find("needs part_temperature_c"),
              std::string::npos);
    EXPECT_NE(complaint("expansion_correction = \"yes\"\n").find("by_machine"), std::string::npos);
    EXPECT_NE(complaint("fixed_at_mm = [1, 2]\n").find("three numbers"), std::string::npos);
}

TEST(UncertaintySpec, IsSaidInAReport) {
    EXPECT_EQ(uncertainty_words(read("")), "");
    EXPECT_EQ(uncertainty_words(read("length_um = 1.9\nlength_k_mm_per_um = 300\nprobing_size_um = 1.2\n")),
              "E0 1.9 um + L/300 mm/um; P_Size 1.2 um");
    EXPECT_EQ(uncertainty_words(read("part_temperature_c = 21.5\nexpansion_um_m_k = 11.5\nexpansion_correction = "
                                     "\"applied\"\n")),
              "part at 21.50 C (u 0.00 K), 11.5 um/(m K) (u 0.0), corrected to 20 C");
}

}  // namespace
}  // namespace cmm::acquisition
