// SPDX-License-Identifier: Apache-2.0
#include "acquisition/traceability.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "acquisition/exports.hpp"
#include "core/text.hpp"
#include "tests/acquisition/judged_part.hpp"
#include "tests/acquisition/nom_blade.hpp"
#include "tests/acquisition/temp_folder.hpp"

namespace cmm::acquisition {
namespace {

const char* const part_text = R"([part]
name = "rotor"
[nominal]
kind = "nom"
files = ["nominal/rotor.nom"]
[tolerance]
file = "rotor.tol"
[stylus]
radius_mm = 1.0
)";

/// The examples of NIST for FIPS 180-4.
TEST(Sha256, IsThatOfTheStandard) {
    EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Traceability, SourcesAreThePartFileAndWhatItNames) {
    const TempFolder folder;
    const auto nominal = nom::written(nom::Blade());
    const std::string tolerances = "NUM_SECT 3\nCHORD 0.05 -0.05\n";
    folder.write("nominal/rotor.nom", nominal);
    folder.write("rotor.tol", tolerances);
    const auto part = load_part_file(folder.write("rotor.toml", part_text));
    ASSERT_TRUE(part) << part.error().text();
    const auto sources = sources_of(*part);
    ASSERT_EQ(sources.size(), 3U);
    EXPECT_EQ(sources[0].name, "rotor.toml");
    EXPECT_EQ(sources[0].sha256, sha256(part_text));
    EXPECT_EQ(sources[1].name, "rotor.nom");
    EXPECT_EQ(sources[1].sha256, sha256(nominal));
    EXPECT_EQ(sources[2].name, "rotor.tol");
    EXPECT_EQ(sources[2].sha256, sha256(tolerances));
}

TEST(Traceability, AFileThatIsGoneIsUnknownAndNoMore) {
    const TempFolder folder;
    folder.write("nominal/rotor.nom", nom::written(nom::Blade()));
    folder.write("rotor.tol", "NUM_SECT 3\nCHORD 0.05 -0.05\n");
    const auto loaded = load_part_file(folder.write("rotor.toml", part_text)).value();
    std::filesystem::remove(folder.path("rotor.tol"));
    auto part = part_of({section_at(0, 0.0)});
    part.sources = sources_of(loaded);
    ASSERT_EQ(part.sources.size(), 3U);
    EXPECT_EQ(part.sources[2].sha256, "");
    EXPECT_EQ(traceability(part)[2], std::make_pair(std::string("Tolerances"),
                                                    std::string("rotor.tol, SHA-256 unknown: it could not be read")));
    const auto json = nlohmann::json::parse(result_json(part)).at("traceability");
    EXPECT_TRUE(json.at("sources").at(2).at("sha256").is_null());
    EXPECT_TRUE(json.at("plan_hash").is_null()) << "not of a run";
}

TEST(Traceability, TheHashOfThePointsIsThatOfTheirFile) {
    const TempFolder folder;
    auto part = part_of({section_at(0, 0.0)});
    part.plan_hash = "0123456789abcdef";
    ASSERT_TRUE(write_outputs(part, folder.path("out")));
    const auto result = nlohmann::json::parse(core::read_file(folder.path("out/result.json")).value());
    const auto& json = result.at("traceability");
    EXPECT_EQ(json.at("points_csv_sha256"), sha256(core::read_file(folder.path("out/points.csv")).value()));
    EXPECT_EQ(json.at("plan_hash"), part.plan_hash);
    const auto report = core::read_file(folder.path("out/report.html")).value();
    EXPECT_NE(report.find(json.at("points_csv_sha256")), std::string::npos);
    EXPECT_NE(report.find(part.plan_hash), std::string::npos);
}

TEST(Traceability, CountsWhatPeopleDecided) {
    auto part = part_of({section_at(0, 0.0), section_at(1, 0.0)});
    EXPECT_EQ(traceability(part).back().second, "none");
    part.sections[0].points[3].verdict.reason = fitting::RejectReason::by_operator;
    part.sections[1].points[4].verdict.reason = fitting::RejectReason::by_operator;
    part.sections[1].points[9].verdict.kept = true;
    EXPECT_EQ(traceability(part).back().second, "points left out: 2, kept: 1");
    const auto json = nlohmann::json::parse(result_json(part)).at("traceability");
    EXPECT_EQ(json.at("left_out_by_operator"), 2);
    EXPECT_EQ(json.at("kept_by_operator"), 1);
}

}  // namespace
}  // namespace cmm::acquisition
