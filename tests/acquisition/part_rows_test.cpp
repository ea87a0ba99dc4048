// SPDX-License-Identifier: Apache-2.0
// The surface through a part's contours where not all of them were measured all round.
#include "acquisition/part_rows.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "fitting/closest_point.hpp"
#include "fitting/surface_fit.hpp"
#include "fitting/surface_index.hpp"
#include "tests/acquisition/gapped_part.hpp"

namespace cmm::acquisition {
namespace {

constexpr double more_material_mm = 0.3;  // than the nominal, which lends its way over an edge that is missing

bool round_the_le(const RecordedPoint& point, const Eigen::Vector2d&) {
    return point.centre_mm.x() < -6.0;
}

PartResult thick_part_without(const Missing& missing, const std::vector<std::size_t>& sections,
                              const std::string& heights = "[16, 18, 20, 22, 24, 26, 28]", std::uint64_t seed = 1) {
    std::string text = leaning_text("profile_mm = 0.2\n");
    for (const auto& [from, to] :
         {std::pair<std::string, std::string>{"[20, 25, 30]", heights}, {"pitch_mm = 0.5", "pitch_mm = 0.25"}})
        text.replace(text.find(from), from.size(), to);
    return judged_part_without(missing, text, sections, more_material_mm, 100, 1e-3, seed);
}

core::Result<std::vector<fitting::SurfaceRow>> rows_of(const PartResult& part) {
    std::vector<const SectionResult*> sections;
    for (const auto& section : part.sections)
        sections.push_back(&section);
    return part_rows(sections);
}

/// How far the surface through all rows is from what was measured of their contours, at most.
double most_off_mm(const PartResult& part) {
    const auto rows = rows_of(part);
    EXPECT_TRUE(rows) << rows.error().text();
    if (!rows) return 1e3;
    const auto fit = fitting::fit_surface(*rows);
    EXPECT_TRUE(fit) << fit.error().text();
    if (!fit) return 1e3;
    const fitting::SurfaceIndex index(fit->surface);
    double most = 0.0;
    for (const auto& section : part.sections)
        for (std::size_t k = 0; k < section.fit->contour.size(); k += 4) {
            const auto& point = section.fit->contour[k];
            const Eigen::Vector3d at(point.position_mm.x(), point.position_mm.y(), section.z_mm);
            if (point.measured) most = std::max(most, index.closest(at).squared);
        }
    return std::sqrt(most);
}

TEST(PartRows, WhatBridgesAGapBendsNothing) {
    for (const auto& [missing, name] : {std::pair{Missing(round_the_le), "LE"}, {Missing(round_the_te), "TE"}})
        for (const std::vector<std::size_t>& sections : {std::vector<std::size_t>{3}, {0}, {6}, {2, 3}, {0, 1, 4}}) {
            const auto part = thick_part_without(missing, sections);
            for (const std::size_t k : sections)
                ASSERT_EQ(part.sections[k].gaps().size(), 1U) << name << part.sections[k].why;
            EXPECT_LT(most_off_mm(part), 1.5e-3)
                << name << ", sections " << sections.front() << " ... " << sections.back();
        }
}

TEST(PartRows, OverAGapARowGoesAsTheOthersDo) {
    const auto whole = rows_of(thick_part_without(round_the_le, {}));
    ASSERT_TRUE(whole);
    const std::array<std::size_t, 4> gapped{0, 1, 3, 6};
    constexpr std::uint64_t noises = 4;
    double squares = 0.0;
    for (std::uint64_t noise = 1; noise <= noises; ++noise) {
        const auto part =
            thick_part_without(round_the_le, {gapped.begin(), gapped.end()}, "[16, 18, 20, 22, 24, 26, 28]", noise);
        const auto rows = rows_of(part);
        ASSERT_TRUE(rows);
        ASSERT_EQ(rows->size(), part.sections.size());
        for (const std::size_t k : gapped) {
            const auto& row = rows->at(k);
            EXPECT_EQ(row.z_mm(), part.sections[k].z_mm);
            const double usual_mm = (part.sections[k].fit->le_point_mm - whole->at(k).le()).norm();
            EXPECT_GT(usual_mm, 0.1) << "what the nominal lends is off by 0.3 mm of material";
            const double off_mm = (row.le() - whole->at(k).le()).norm();
            EXPECT_LT(off_mm, k == 0 ? 0.05 : 0.025) << k << ", " << noise;
            squares += off_mm * off_mm / double(gapped.size() * noises);
        }
    }
    EXPECT_LT(std::sqrt(squares), 0.015);
}

/// So many contacts after the first and before the last of a stretch crowd at its ends, with what the fit leaves of
/// them.
void crowd_contacts(std::vector<fitting::ContourPoint>& contour, std::size_t first, std::size_t count, double step_mm,
                    double off_mm) {
    const Eigen::Vector2d from = contour[first].position_mm, to = contour[first + 2 * count].position_mm;
    const Eigen::Vector2d along = (to - from).normalized(), across(-along.y(), along.x());
    for (std::size_t i = 0; i < count; ++i) {
        const double moved_mm = step_mm * static_cast<double>(i), aside_mm = i % 2 == 0 ? off_mm : -off_mm;
        contour[first + i].position_mm = from + moved_mm * along + aside_mm * across;
        contour[first + 2 * count - i].position_mm = to - moved_mm * along + aside_mm * across;
    }
    contour[first + count].position_mm = to - step_mm * static_cast<double>(count) * along;
}

/// Where the ball's way is nearly as bent as the ball its contacts crowd, to a tenth of a micrometre, and lie 0.3 mm
/// apart beside that: a row that followed all of them ran forth and back there.
TEST(PartRows, CrowdedContactsMakeNoLoop) {
    const auto part = thick_part_without(round_the_le, {});
    const auto smooth = rows_of(part);
    ASSERT_TRUE(smooth);
    for (const std::size_t first : {30, 100, 1000})
        for (const double step_mm : {1e-4, 2e-4})
            for (const double off_mm : {0.0, 2e-5, 1e-4}) {
                auto crowd = part;
                crowd_contacts(crowd.sections[3].fit->contour, first, 20, step_mm, off_mm);
                const auto rows = rows_of(crowd);
                ASSERT_TRUE(rows);
                EXPECT_NEAR(rows->at(3).length_mm(), smooth->at(3).length_mm(), 2e-3)
                    << first << ", " << step_mm << ", " << off_mm;
            }
}

TEST(PartRows, WithFewerThanTwoWholeSectionsTheyKeepTheirBridges) {
    const auto part = thick_part_without(on_suction_side, {0, 1}, "[20, 25, 30]");
    EXPECT_LT(most_off_mm(part), 1.5e-3);
    const auto rows = rows_of(part);
    ASSERT_TRUE(rows);
    for (std::size_t k = 0; k < rows->size(); ++k) {
        const fitting::ClosestPointIndex index(rows->at(k).smooth().curve);
        for (const auto& point : part.sections[k].fit->contour)
            ASSERT_LT(std::sqrt(index.closest(point.position_mm).squared), 1e-3);
    }
    EXPECT_EQ(part_rows({})->size(), 0U);
}

}  // namespace
}  // namespace cmm::acquisition
