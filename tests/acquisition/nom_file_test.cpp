// SPDX-License-Identifier: Apache-2.0
#include "acquisition/nom_file.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "acquisition/nominal_kinds.hpp"
#include "acquisition/reference_contour.hpp"
#include "tests/acquisition/nom_blade.hpp"
#include "tests/acquisition/temp_folder.hpp"
#include "tests/acquisition/test_blade.hpp"

namespace cmm::acquisition {
namespace {

using nom::Blade;
using nom::written;

NomFile parsed(const std::string& text) {
    auto file = parse_nom(text, "b.nom", {});
    EXPECT_TRUE(file) << file.error().text();
    return file ? std::move(*file) : NomFile{};
}

std::shared_ptr<const Nominal> nominal_of(const std::string& text) {
    const auto nominal = nom_nominal(parsed(text));
    EXPECT_TRUE(nominal) << nominal.error().text();
    return nominal.value_or(nullptr);
}

NominalContour section_at(const Nominal& nominal, double z_mm) {
    const auto contour = nominal.cut(z_mm);
    EXPECT_TRUE(contour) << contour.error().text();
    return contour.value_or(NominalContour{});
}

/// Tolerances that vary along the contour and with the height.
std::pair<double, double> waving(const synthetic::ContourPoint& point, double z_mm) {
    const double size = 0.05 + 0.02 * std::sin(0.1 * point.position_mm.x()) + 1e-4 * z_mm;
    return {-0.5 * size, size};
}

TEST(NomFile, ReadsSectionsWithNormalsTolerancesAndEnds) {
    const Blade blade;
    const auto file = parsed(written(blade, {.tolerance = waving}));
    EXPECT_FALSE(file.inches);
    ASSERT_EQ(file.sections.size(), 3U);
    const auto& section = file.sections[1];
    EXPECT_EQ(section.name, "B-B");
    EXPECT_DOUBLE_EQ(section.z_mm, 25.0);
    const synthetic::Section truth(blade.shape);
    const auto contour = truth.contour(blade.per_side, blade.per_edge);
    ASSERT_EQ(section.points_mm.size(), contour.size());
    ASSERT_EQ(section.tolerances.size(), contour.size());
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const auto p = blade.at_height(contour[i].position_mm, 25.0);
        EXPECT_LT((section.points_mm[i].head<2>() - p).norm(), 1e-9);
        EXPECT_LT((section.normals[i] - blade.normal(contour[i].normal)).norm(), 1e-9);
        EXPECT_NEAR(section.tolerances[i].below_mm, waving(contour[i], 25.0).first, 1e-9);
        EXPECT_NEAR(section.tolerances[i].above_mm, waving(contour[i], 25.0).second, 1e-9);
    }
    EXPECT_LT((*section.nose_mm - blade.at_height(truth.nose(), 25.0)).norm(), 1e-9);
    EXPECT_LT((*section.tail_mm - blade.at_height(truth.tail(), 25.0)).norm(), 1e-9);
    EXPECT_DOUBLE_EQ((*section.offsets_mm)[0], 1.5);
    EXPECT_DOUBLE_EQ((*section.offsets_mm)[1], 1.2);
}

TEST(NomFile, InchesCommasDirectionAndClosingPointMakeNoDifference) {
    const Blade blade;
    const auto plain = nominal_of(written(blade, {.tolerance = waving}));
    for (const auto& how :
         {nom::Writing{.inches = true, .tolerance = waving}, nom::Writing{.separator = ",", .tolerance = waving},
          nom::Writing{.clockwise = true, .tolerance = waving},
          nom::Writing{.closing_point = true, .tolerance = waving}}) {
        const auto other = nominal_of(written(blade, how));
        for (const double z : {10.0, 18.0, 40.0}) {
            const auto a = section_at(*plain, z), b = section_at(*other, z);
            EXPECT_LT(largest_distance(a.points, b.points), 1e-4) << z;
            EXPECT_NEAR(a.lean_rad, b.lean_rad, 1e-4);
            EXPECT_LT((*a.le_mm - *b.le_mm).norm(), 1e-8);
            const auto tolerances = [](const NominalContour& contour) {
                return ReferenceContour(contour, fitting::ClosedCurve::through(contour.points).value(), 0.0);
            };
            const auto of_a = tolerances(a), of_b = tolerances(b);
            for (const auto& p : a.points) {
                const auto at_a = of_a.tolerance_at(of_a.compare(p, {0.0, 0.0}, {}).s_mm);
                const auto at_b = of_b.tolerance_at(of_b.compare(p, {0.0, 0.0}, {}).s_mm);
                ASSERT_NEAR(at_a.below_mm, at_b.below_mm, 2e-5);
                ASSERT_NEAR(at_a.above_mm, at_b.above_mm, 2e-5);
            }
        }
    }
}

void expect_is_the_blade(const Blade& blade, const Nominal& nominal) {
    const auto dense = synthetic::Section(blade.shape).contour(4000, 2000);
    for (const double z : {10.0, 25.0, 31.0}) {
        const auto contour = section_at(nominal, z);
        ASSERT_EQ(contour.leans_rad.size(), contour.points.size());
        ASSERT_EQ(contour.tolerances.size(), contour.points.size());
        double off_mm = 0.0, off_lean = 0.0, off_tolerance = 0.0;
        for (std::size_t i = 0; i < contour.points.size(); ++i) {
            const auto nearest = std::min_element(dense.begin(), dense.end(), [&](const auto& a, const auto& b) {
                const auto far = [&](const auto& p) {
                    return (blade.at_height(p.position_mm, z) - contour.points[i]).squaredNorm();
                };
                return far(a) < far(b);
            });
            off_mm = std::max(
                off_mm, std::abs((contour.points[i] - blade.at_height(nearest->position_mm, z)).dot(nearest->normal)));
            off_lean = std::max(off_lean, std::abs(contour.leans_rad[i] - blade.lean_at(nearest->normal)));
            off_tolerance =
                std::max(off_tolerance, std::abs(contour.tolerances[i].above_mm - waving(*nearest, z).second));
        }
        EXPECT_LT(off_mm, 0.0005) << z;  // between points: the spline through those of the file
        EXPECT_LT(off_lean, z == 31.0 ? 0.01 : 0.002) << z;
        EXPECT_LT(off_tolerance, 0.0002) << z;
    }
}

TEST(NomFile, TheNominalIsTheBladeAtAndBetweenItsSections) {
    Blade blade;
    blade.per_side = 400;
    blade.per_edge = 200;
    const auto nominal = nominal_of(written(blade, {.tolerance = waving}));
    EXPECT_DOUBLE_EQ(nominal->z_low_mm(), 10.0);
    EXPECT_DOUBLE_EQ(nominal->z_high_mm(), 40.0);
    expect_is_the_blade(blade, *nominal);
}

TEST(NomFile, SectionsMayBeginAtDifferentPlaces) {
    Blade blade;
    blade.per_side = 400;
    blade.per_edge = 200;
    expect_is_the_blade(blade, *nominal_of(written(blade, {.tolerance = waving, .starts = {0, 300, 1}})));
}

TEST(NomFile, NoseAndTailSayWhichEdgeIsWhich) {
    const Blade blade;
    for (const bool swapped : {false, true}) {
        const auto nominal = nominal_of(written(blade, {.nose_at_te = swapped}));
        const auto contour = section_at(*nominal, 30.0);
        const auto section = fitting::analyse_nominal(contour.points, edge_hints({}, contour)).value();
        const synthetic::Section truth(blade.shape);
        const auto expected = blade.at_height(swapped ? truth.tail() : truth.nose(), 30.0);
        EXPECT_LT((section.le_point() - expected).norm(), 0.1);
        // What the part file says stands above.
        NominalSpec spec;
        spec.le_hint_mm = blade.at_height(truth.nose(), 30.0);
        EXPECT_LT((fitting::analyse_nominal(contour.points, edge_hints(spec, contour))->le_point() -
                   blade.at_height(truth.nose(), 30.0))
                      .norm(),
                  0.1);
    }
}

TEST(NomFile, TolerancesHoldBetweenSectionsOnlyPointByPoint) {
    Blade blade;
    std::string text = written(blade, {.tolerance = waving});
    // The last section once more, with one point less.
    const auto last = text.find("SECTION C-C");
    std::string section = text.substr(last);
    const auto count = std::to_string(2 * blade.per_side + 2 * blade.per_edge);
    section.replace(section.find(count), count.size(), std::to_string(2 * blade.per_side + 2 * blade.per_edge - 1));
    section.erase(section.rfind('\n', section.size() - 2) + 1);
    const auto nominal = nominal_of(text.substr(0, last) + section);
    EXPECT_EQ(section_at(*nominal, 25.0).tolerances.size(), section_at(*nominal, 25.0).points.size());
    const auto between = nominal->cut(30.0);
    ASSERT_FALSE(between);
    EXPECT_EQ(between.error().code, core::ErrorCode::plan_invalid);
    EXPECT_NE(between.error().message.find("section C-C"), std::string::npos) << between.error().message;
}

struct Spoiled {
    const char *from, *to, *said;
};

TEST(NomFile, SaysWhereAndWhatIsWrong) {
    const std::string eight =
        "SECTION A 8 5\nNOSE 1 2 SQUARE\nTAIL 5\n1 0 5 1 0 0\n1 1 5 1 0 0\n0 1 5 0 1 0\n"
        "-1 1 5 -1 0 0\n-1 0 5 -1 0 0\n-1 -1 5 -1 0 0\n0 -1 5 0 -1 0\n1 -1 5 1 0 0\n";
    const std::string good = "UNITS MM\nNUM_SECT 1\n" + eight;
    EXPECT_TRUE(parse_nom(good, "b.nom", {}));
    for (const auto& [from, to, said] :
         {Spoiled{"UNITS MM\n", "", "b.nom:2:1: UNITS INCH or UNITS MM must stand before"},
          Spoiled{"UNITS MM", "UNITS CM", "b.nom:1:7: UNITS must be INCH or MM"},
          Spoiled{"UNITS MM", "UNITS INCH\nUNITS MM", "b.nom:2:7: UNITS says something else than before"},
          Spoiled{"NUM_SECT 1\n", "", "no line NUM_SECT"},
          Spoiled{"NUM_SECT 1", "NUM_SECT 2", "NUM_SECT says 2 sections, the file has 1"},
          Spoiled{"NUM_SECT 1", "NUM_SECT 1.5", "b.nom:2:10: NUM_SECT must be a whole number"},
          Spoiled{"A 8 5\n", "A 9 5\n", "b.nom:3:11: section A has 8 points where it says 9"},
          Spoiled{"A 8 5\n", "A 8 5 Q\n", "b.nom:3:15: 'Q' is neither I nor SKEWED"},
          Spoiled{"SECTION A 8 5", "SECTION A 8", "SECTION needs a name"},
          Spoiled{"NOSE", "NOES", "b.nom:4:1"},
          Spoiled{"NOSE 1 2", "NOSE 1 9", "b.nom:4:8: the point must be a whole number from 1 to 8"},
          Spoiled{"NOSE 1 2 SQUARE", "NOSE SQUARE", "NOSE names no point"},
          Spoiled{"NOSE 1 2 SQUARE", "NOSE 5", "b.nom:5:6: NOSE and TAIL are at one place"},
          Spoiled{"SQUARE", "FORCE", "b.nom:4:10: FORCE: where the camber line ends"},
          Spoiled{"SQUARE", "PARTIAL", "b.nom:4:10: PARTIAL: open ends are not measured"},
          Spoiled{"SQUARE", "ROUND", "b.nom:4:10: 'ROUND': one or two points are followed by"},
          Spoiled{"TAIL 5", "TAIL 5\nTAIL 4", "b.nom:6:1: a second TAIL"},
          Spoiled{"TAIL 5", "TAIL 5\nOFFSETS 1 0", "b.nom:6:11: an offset must be above 0"},
          Spoiled{"1 1 5 1 0 0", "1 1 5", "b.nom:7:5: a point is X Y Z I J K"},
          Spoiled{"1 1 5 1 0 0", "1 1 6 1 0 0", "b.nom:7:5: Z is not the height of section A"},
          Spoiled{"1 1 5 1 0 0", "1 1 5 0 0 0", "b.nom:7:7: I J K is no unit vector"},
          Spoiled{"1 1 5 1 0 0", "1 nan 5 1 0 0", "b.nom:7:3: Y is not a finite number"},
          Spoiled{"1 1 5 1 0 0", "1e9 1 5 1 0 0", "b.nom:7:1: X is more than 100 m"},
          Spoiled{"1 1 5 1 0 0", "1 1 5 1 0 0 -0.1 0.1", "b.nom:7:13: all points of a section have tolerances"},
          Spoiled{"1 0 5 1 0 0", "1 0 5 1 0 0 0.1 0.2", "b.nom:6:13: the minus tolerance is a deviation"},
          Spoiled{"1 0 5 1 0 0", "1 0 5 1 0 0 -0.1 -0.2", "b.nom:6:18: the plus tolerance must be above"},
          Spoiled{"1 -1 5 1 0 0\n", "1 -1 5 1 0 0\n0 0 5 1 0 0\n", "b.nom:14:1: more points than SECTION A says"},
          Spoiled{"1 -1 5 1 0 0\n", "1 -1 5 1 0 0\nSECTON B 8 6\n", "did you mean SECTION?"}}) {
        std::string text = good;
        const auto at = text.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        text.replace(at, std::string_view(from).size(), to);
        const auto file = parse_nom(text, "b.nom", {});
        ASSERT_FALSE(file) << said;
        EXPECT_EQ(file.error().code, core::ErrorCode::input_invalid);
        EXPECT_NE(file.error().message.find(said), std::string::npos) << file.error().message << "\nnot: " << said;
    }
    const std::vector<std::string> skip{"force", "PARTIAL"};
    for (const char* word : {"FORCE", "PARTIAL"}) {
        std::string text = good;
        EXPECT_TRUE(parse_nom(text.replace(text.find("SQUARE"), 6, word), "b.nom", skip)) << word;
    }
}

TEST(NomFile, APartFileTakesItsHeightsFromTheSections) {
    const TempFolder folder;
    const Blade blade;
    folder.write("b.nom", written(blade));
    const std::string text = "[part]\nname = \"n\"\n[nominal]\nkind = \"nom\"\nfiles = [\"b.nom\"]\n";
    const auto part = load_part_file(folder.write("p.toml", text));
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->scan.heights_mm, blade.heights_mm);
    const auto chosen = load_part_file(folder.write("q.toml", text + "[scan]\nheights_mm = [12]\n"));
    ASSERT_TRUE(chosen) << chosen.error().text();
    EXPECT_EQ(chosen->scan.heights_mm, (std::vector<double>{12.0}));
    const auto absent = load_part_file(folder.write("r.toml",
                                                    "[part]\nname = \"n\"\n[nominal]\nkind = \"nom\"\n"
                                                    "files = [\"c.nom\"]\n"));
    ASSERT_FALSE(absent);
    EXPECT_EQ(absent.error().code, core::ErrorCode::input_missing);
}

}  // namespace
}  // namespace cmm::acquisition
