// SPDX-License-Identifier: Apache-2.0
#include "acquisition/tol_file.hpp"

#include <gtest/gtest.h>

#include "acquisition/nom_file.hpp"
#include "acquisition/part_file.hpp"
#include "acquisition/tol_characteristics.hpp"
#include "core/units.hpp"
#include "tests/acquisition/nom_blade.hpp"
#include "tests/acquisition/temp_folder.hpp"

namespace cmm::acquisition {
namespace {

using Kind = CharacteristicKind;

const nom::Blade blade;  // sections A-A, B-B, C-C at 10, 25, 40 mm

core::Result<std::vector<CharacteristicSpec>> asked(const std::string& text, std::vector<std::string> skip = {},
                                                    const std::vector<double>& heights = blade.heights_mm) {
    const auto nom = parse_nom(nom::written(blade), "b.nom", {}).value();
    const auto tol = parse_tol(text, "b.tol", skip, false);
    if (!tol) return tl::unexpected(tol.error());
    return characteristics_of(*tol, &nom, heights);
}

CharacteristicSpec spec(const std::vector<CharacteristicSpec>& specs, const std::string& label, std::size_t section) {
    for (const auto& one : specs)
        if (one.label == label && one.is_of(section)) return one;
    ADD_FAILURE() << "no " << label;
    return {};
}

TEST(TolFile, TolerancesOfAllSectionsAndOfSingleOnes) {
    const auto specs = asked(
        "NUM_SECT 3\n"
        "LE_OFFSET 1.0\nLE_OFFSET2 2.5\nLE_ANGOFFSET 1 4\nROOTSECT A-A\nTIPSECT C-C\nTE_CHANGE 1.5\n"
        "CHORD 0.05 -0.03\nMAXTHK 0.02 -0.02 6.1\nLETHCK 0.04 -0.04\nLETHCK2 0.06 -0.06\n"
        "TETHCK 0.05 -0.05\nLEANGLE 0.5 -0.25\nTWIST 0.25 -0.25\nLECONT 0.08 0\nBOWT 0.1 0\n"
        "SECTION B-B\nCHORD 0.07 -0.07\nLE_OFFSET 1.4\n"
        "SETSPEC\nMAXTHK 5.9 6.05\n");
    ASSERT_TRUE(specs) << specs.error().text();
    const auto chord = spec(*specs, "chord_tangent", 0);
    EXPECT_EQ(chord.chord, fitting::ChordMethod::caliper);
    EXPECT_EQ(chord.sections, (std::vector<std::size_t>{0, 2}));
    EXPECT_DOUBLE_EQ(*chord.above, 0.05);
    EXPECT_DOUBLE_EQ(*chord.below, -0.03);
    EXPECT_FALSE(chord.nominal);
    EXPECT_DOUBLE_EQ(*spec(*specs, "chord_tangent", 1).above, 0.07);
    EXPECT_DOUBLE_EQ(*spec(*specs, "max_thickness", 2).nominal, 6.1);
    const auto limits = spec(*specs, "max_thickness", 1);
    EXPECT_DOUBLE_EQ(*limits.nominal + *limits.above, 6.05);
    EXPECT_DOUBLE_EQ(*limits.nominal + *limits.below, 5.9);
    // Distances of the tolerance file stand above those of the nominal file (1.5 and 1.2 mm).
    EXPECT_DOUBLE_EQ(spec(*specs, "le_thickness_1", 0).distance_mm, 1.0);
    EXPECT_DOUBLE_EQ(spec(*specs, "le_thickness_1.4", 1).distance_mm, 1.4);
    EXPECT_DOUBLE_EQ(*spec(*specs, "le_thickness_2.5", 1).above, 0.06);
    EXPECT_DOUBLE_EQ(spec(*specs, "te_thickness_1.2", 0).distance_mm, 1.2);
    EXPECT_TRUE(spec(*specs, "te_thickness_1.2", 0).sections.empty());  // of all
    const auto angle = spec(*specs, "le_angle_1_4", 0);
    EXPECT_DOUBLE_EQ(*angle.above, core::rad_from_deg(0.5));
    EXPECT_DOUBLE_EQ(*angle.below, core::rad_from_deg(-0.25));
    EXPECT_DOUBLE_EQ(angle.far_mm, 4.0);
    EXPECT_DOUBLE_EQ(*spec(*specs, "twist", 0).above, core::rad_from_deg(0.25));
    EXPECT_DOUBLE_EQ(*spec(*specs, "profile_form_le", 0).above, 0.08);
    EXPECT_DOUBLE_EQ(*spec(*specs, "profile_form_le", 0).te_change_mm, 1.5);
    EXPECT_FALSE(spec(*specs, "profile_form_le", 0).le_change_mm);
    const auto bow = spec(*specs, "bow_true_position", 1);
    EXPECT_EQ(bow.root, 0U);
    EXPECT_EQ(bow.tip, 2U);
}

TEST(TolFile, RelativeTwistIsThatToTheReferenceSection) {
    const auto specs = asked("REFSECT B-B\nRELTWIST 0.1 -0.2\nBOWT 0.1 0\n");
    ASSERT_TRUE(specs) << specs.error().text();
    const auto twist = spec(*specs, "relative_twist", 2);
    EXPECT_EQ(twist.kind, Kind::relative_twist);
    EXPECT_EQ(twist.reference_section, 1U);
    EXPECT_DOUBLE_EQ(*twist.above, core::rad_from_deg(0.1));
    EXPECT_DOUBLE_EQ(*twist.below, core::rad_from_deg(-0.2));
    EXPECT_FALSE(spec(*asked("RELTWIST 0.1 -0.2\n"), "relative_twist", 0).reference_section) << "the root";
}

TEST(TolFile, ExcludedSidesTakeNoPartInTheBestFit) {
    // Convex 1, concave 2, LE 4, TE 8.
    const auto specs = asked("EXCLUDE1 12\nTWIST 0.25 -0.25\nLECONT 0.08 0\nCHORD 0.1 -0.1\nRELTWIST 1 -1\n");
    ASSERT_TRUE(specs) << specs.error().text();
    const ZoneSet sides{false, true, false, true};
    EXPECT_EQ(spec(*specs, "twist", 1).fit_zones, sides);
    EXPECT_EQ(spec(*specs, "profile_form_le", 1).fit_zones, sides);
    EXPECT_EQ(spec(*specs, "relative_twist", 1).fit_zones, sides);
    EXPECT_EQ(spec(*specs, "chord_tangent", 1).fit_zones, all_zones) << "no best fit";
    const auto own = asked("TWIST 0.25 -0.25\nSECTION B-B\nEXCLUDE1 1\nSECTION C-C\nEXCLUDE1 2\n");
    ASSERT_TRUE(own) << own.error().text();
    EXPECT_EQ(spec(*own, "twist", 0).fit_zones, all_zones);
    EXPECT_EQ(spec(*own, "twist", 1).fit_zones, (ZoneSet{true, false, true, true}));
    EXPECT_EQ(spec(*own, "twist", 2).fit_zones, (ZoneSet{true, true, true, false}));
}

TEST(TolFile, InchesAreThoseOfTheFileOrOfTheNominal) {
    const auto own = parse_tol("UNITS INCH\nCHORD 0.001 -0.002\n", "b.tol", {}, false).value();
    EXPECT_DOUBLE_EQ(own.blocks[0].entries[0].numbers[0], 0.0254);
    EXPECT_DOUBLE_EQ(own.blocks[0].entries[0].numbers[1], -0.0508);
    const auto inherited = parse_tol("CHORD 0.001 -0.002\nTWIST 1 -1\n", "b.tol", {}, true).value();
    EXPECT_DOUBLE_EQ(inherited.blocks[0].entries[0].numbers[0], 0.0254);
    EXPECT_DOUBLE_EQ(inherited.blocks[0].entries[1].numbers[0], core::rad_from_deg(1.0));
}

TEST(TolFile, WhatIsNotEvaluatedIsAnErrorUnlessItIsSkipped) {
    const std::string text = "CHORD 0.05 -0.05\nLE_RADII 2\nEXCLUDE2 3\n";
    const auto refused = asked(text);
    ASSERT_FALSE(refused);
    EXPECT_TRUE(refused.error().message.starts_with("b.tol:2:1: LE_RADII is not evaluated")) << refused.error().text();
    const auto skipped = asked(text, {"le_radii", "EXCLUDE2"});
    ASSERT_TRUE(skipped) << skipped.error().text();
    EXPECT_EQ(skipped->size(), 1U);
}

TEST(TolFile, SaysWhereAndWhatIsWrong) {
    struct Case {
        const char *text, *said;
    };
    for (const auto& [text, said] :
         {Case{"NUM_SECT 4\n", "b.tol:1:1: NUM_SECT says 4 sections, the nominal file has 3"},
          Case{"CHORDS 1 -1\n", "did you mean CHORD?"},
          Case{"CHORD 0.05\n", "b.tol:1:7: the lower tolerance is missing"},
          Case{"CHORD x -1\n", "b.tol:1:7: the upper tolerance is not a number"},
          Case{"CHORD 0.05 0.05\n", "b.tol:1:7: the upper tolerance comes first"},
          Case{"CHORD -0.05 0.05\n", "b.tol:1:7: the upper tolerance comes first"},
          Case{"CHORD 1 -1 60 7\n", "b.tol:1:15: '7' is more than CHORD takes"},
          Case{"CHORD 1 -1\nCHORD 2 -2\n", "b.tol:2:1: CHORD stands twice"},
          Case{"LECONT 0.08 -0.08\n", "b.tol:1:13: LECONT is the full width of a zone"},
          Case{"LETHCK2 1 -1\n", "b.tol:1:1: LETHCK2 needs its distance from the edge: LE_OFFSET2"},
          Case{"LEANGLE 1 -1\n", "needs the two distances of LE_ANGOFFSET"},
          Case{"LE_ANGOFFSET 4 1\n", "b.tol:1:16: the second distance must be larger"},
          Case{"LE_OFFSET 0\n", "b.tol:1:11: a distance must lie between"},
          Case{"LETHCK11 1 -1\n", "b.tol:1:1: LETHCK11 is not evaluated"},
          Case{"EXCLUDE3 5\n",
               "b.tol:1:1: EXCLUDE3 is not evaluated: it is of a second best fit, which a flavor file says"},
          Case{"EXCLUDE1 15\n", "b.tol:1:10: all sides are left out of the best fit"},
          Case{"EXCLUDE1 16\n", "b.tol:1:10: "},
          Case{"RELTWIST 1 -1\nSECTION B-B\nEXCLUDE1 4\n",
               "b.tol:3:1: EXCLUDE1 of a single section: RELTWIST compares sections"},
          Case{"RELTWIST2 1 -1\n", "RELTWIST2 is not evaluated: which section or datum"},
          Case{"EXCLUDE6 5\n", "b.tol:1:1: EXCLUDE6 is not evaluated (did you mean EXCLUDE1?); to go on"},
          Case{"TE_RADII 2\n", "TE_RADII is not evaluated: it is the ring of points of a best fit by an edge's arc"},
          Case{"LE_FLAT_SIZE2 2\n",
               "LE_FLAT_SIZE2 is not evaluated: it is the zone of the methods SQUARE and OFFSETFLAT"},
          Case{"ROOTANG 12.5\n", "ROOTANG is not evaluated: angles are from +x"},
          Case{"REFSECT D-D\n", "b.tol:1:1: the nominal has no section 'D-D'"},
          Case{"SECTION D-D\nCHORD 1 -1\n", "b.tol:1:1: the nominal has no section 'D-D'; it has A-A, B-B, C-C"},
          Case{"ROOTSECT\n", "b.tol:1:1: ROOTSECT needs the name of a section"},
          Case{"CHORD 1 -1\nUNITS MM\n", "b.tol:2:1: UNITS must stand before the first length"},
          Case{"UNITS MM\nUNITS INCH\nCHORD 1 -1\n", "b.tol:2:7: UNITS says something else than before"},
          Case{"SETTOL 1\n", "b.tol:1:8: '1' is more than SETTOL takes"},
          Case{"! nothing\n", "b.tol: there is nothing but comments in it"}}) {
        const auto specs = asked(text);
        ASSERT_FALSE(specs) << said;
        EXPECT_EQ(specs.error().code, core::ErrorCode::input_invalid);
        EXPECT_NE(specs.error().message.find(said), std::string::npos) << specs.error().message << "\nnot: " << said;
    }
    const auto not_measured = asked("ROOTSECT A-A\nTIPSECT C-C\nBOWT 0.1 0\n", {}, {10.0, 25.0});
    ASSERT_FALSE(not_measured);
    EXPECT_NE(not_measured.error().message.find("b.tol:2:1: section C-C is not among the heights"), std::string::npos);
}

TEST(TolFile, APartFileTakesItsCharacteristics) {
    const TempFolder folder;
    folder.write("b.nom", nom::written(blade));
    folder.write("b.tol", "CHORD 0.05 -0.05\nSECTION C-C\nMAXTHK 0.1 -0.1\n");
    const std::string text =
        "[part]\nname = \"n\"\n[nominal]\nkind = \"nom\"\nfiles = [\"b.nom\"]\n[tolerance]\nfile = \"b.tol\"\n";
    const auto part = load_part_file(folder.write("p.toml", text));
    ASSERT_TRUE(part) << part.error().text();
    ASSERT_EQ(part->gate.characteristics.size(), 2U);
    EXPECT_EQ(part->gate.characteristics[1].sections, (std::vector<std::size_t>{2}));
    const auto twice =
        load_part_file(folder.write("q.toml", text + "[[characteristic]]\nname = \"chord\"\nmethod = \"TANGENT\"\n"));
    ASSERT_FALSE(twice);
    EXPECT_NE(twice.error().message.find("\"chord_tangent\" is asked for by a [[characteristic]] and by"),
              std::string::npos)
        << twice.error().message;
    // Without names of sections any nominal will do.
    folder.write("plain.tol", "CHORD 0.05 -0.05\n");
    const auto unnamed = load_part_file(folder.write(
        "r.toml",
        "[part]\nname = \"n\"\n[nominal]\nkind = \"none\"\n[scan]\nheights_mm = [1]\nbox_mm = [0, 0, 9, 9]\n"
        "[tolerance]\nfile = \"plain.tol\"\n"));
    ASSERT_TRUE(unnamed) << unnamed.error().text();
    EXPECT_EQ(unnamed->gate.characteristics.size(), 1U);
}

}  // namespace
}  // namespace cmm::acquisition
