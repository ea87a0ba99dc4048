// SPDX-License-Identifier: Apache-2.0
#include "acquisition/points_out.hpp"

#include <gtest/gtest.h>

#include "core/rng.hpp"
#include "tests/acquisition/judged_part.hpp"
#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {
namespace {

CharacteristicSpec asked(std::optional<fitting::Zone> zone, std::optional<double> upper = {}) {
    CharacteristicSpec spec;
    spec.kind = CharacteristicKind::points_out;
    spec.label = "points_out";
    spec.zone = zone;
    spec.nominal = 0.0;
    spec.above = upper;
    return spec;
}

EvaluationOptions gate() {
    EvaluationOptions options;
    options.profile_mm = 0.10;
    options.edge_profile_mm = 0.06;
    return options;
}

std::size_t points_in(const SectionResult& section, fitting::Zone zone) {
    std::size_t count = 0;
    for (const auto& point : section.points) {
        const auto& contour = section.fit->contour;
        const auto nearest = std::min_element(contour.begin(), contour.end(), [&](const auto& a, const auto& b) {
            return (a.position_mm - point.centre_mm.head<2>()).norm() <
                   (b.position_mm - point.centre_mm.head<2>()).norm();
        });
        count += nearest->zone == zone && point.verdict.reason == fitting::RejectReason::none;
    }
    return count;
}

TEST(PointsOut, CountsThePointsOfItsZone) {
    const auto thick = section_at(0, 0.2);  // the pressure side alone, far beyond half the zone
    const auto all = points_out(asked({}), thick, gate());
    ASSERT_TRUE(all.value) << all.note;
    const auto pressure = points_out(asked(fitting::Zone::pressure, 0.0), thick, gate());
    const auto expected = static_cast<double>(points_in(thick, fitting::Zone::pressure));
    ASSERT_GT(expected, 20.0);
    EXPECT_EQ(pressure.value.value(), expected);
    EXPECT_EQ(all.value.value(), expected) << "the other zones are good";
    EXPECT_EQ(pressure.guard_reject.value(), 0.0) << "far beyond the limit there is no doubt\n" << pressure.note;
    EXPECT_EQ(pressure.decision, Decision::reject);
    EXPECT_TRUE(holds(pressure.note, "(100.0 %)")) << pressure.note;
    const auto suction = points_out(asked(fitting::Zone::suction, 0.0), thick, gate());
    EXPECT_EQ(suction.value.value(), 0.0);
    EXPECT_EQ(suction.decision, Decision::accept);
    EXPECT_EQ(all.decision, Decision::reported) << "no number is too many";
    const auto allowed = points_out(asked(fitting::Zone::pressure, expected), thick, gate());
    EXPECT_EQ(allowed.decision, Decision::accept);
}

TEST(PointsOut, SaysWhyItCannotBeEvaluated) {
    const auto section = section_at(0, 0.0);
    EXPECT_TRUE(holds(points_out(asked({}), section, {}).note, "no tolerance zone"));
    auto own = asked({});
    own.width_mm = 0.001;  // narrower than the form error of 6 um
    EXPECT_GT(points_out(own, section, {}).value.value(), 10.0);
    const auto bare = section_at(0, 0.0, false);
    EXPECT_EQ(points_out(asked({}), bare, gate()).decision, Decision::not_evaluable);
    EXPECT_TRUE(holds(points_out(asked({}), bare, gate()).note, "no nominal"));
}

/// A side that goes out by degrees: the true number lies between what is certain and what is possible.
TEST(PointsOut, TheTrueNumberLiesWithinItsBounds) {
    constexpr int trials = 1000;
    constexpr double noise_mm = 0.004;
    auto exact = section_at(0, 0.0);
    for (std::size_t i = 0; i < exact.fit->contour.size(); ++i)
        exact.deviation_mm[i] = 0.05 + 0.02 * std::sin(exact.fit->contour[i].position_mm.x());
    exact.fit->noise_sigma_mm = noise_mm;
    for (auto& point : exact.points)
        point.verdict.residual_mm = 0.0;
    const auto truth = points_out(asked(fitting::Zone::suction), exact, gate()).value.value();
    ASSERT_GT(truth, 5.0);
    core::Rng rng(3);
    int low = 0, high = 0, plain = 0;
    for (int k = 0; k < trials; ++k) {
        auto noisy = exact;
        for (auto& point : noisy.points)
            point.verdict.residual_mm = noise_mm * rng.normal();
        const auto said = points_out(asked(fitting::Zone::suction), noisy, gate());
        low += *said.value - *said.guard_reject > truth;
        high += *said.value + *said.guard_accept < truth;
        plain += *said.value != truth;
    }
    EXPECT_LE(low, 0.05 * trials);
    EXPECT_LE(high, 0.05 * trials);
    EXPECT_GT(plain, 0.2 * trials) << "the count itself is not certain";
}

TEST(PointsOut, IsReadFromThePartFile) {
    const auto part = parse_part_file(session_part_text() +
                                          "[[characteristic]]\nname = \"points_out\"\nzone = \"le\"\n"
                                          "width_mm = 0.04\nupper = 3\n"
                                          "[[characteristic]]\nname = \"points_out\"\n",
                                      "p.toml");
    ASSERT_TRUE(part) << part.error().text();
    const auto& specs = part->gate.characteristics;
    ASSERT_EQ(specs.size(), 2U);
    EXPECT_EQ(specs[0].label, "points_out_le");
    EXPECT_EQ(specs[0].zone, fitting::Zone::le);
    EXPECT_EQ(specs[0].width_mm, 0.04);
    EXPECT_EQ(specs[0].above, 3.0);
    EXPECT_EQ(specs[1].label, "points_out");
    EXPECT_FALSE(specs[1].zone || specs[1].above);
    EXPECT_FALSE(
        parse_part_file(session_part_text() + "[[characteristic]]\nname = \"points_out\"\ntolerance = 3\n", "p.toml"));
    EXPECT_EQ(worded(3.0, Unit::count), "3");
}

}  // namespace
}  // namespace cmm::acquisition
