// SPDX-License-Identifier: Apache-2.0
#include "acquisition/nominal_measures.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/acquisition/synthetic_blade.hpp"

namespace cmm::acquisition {
namespace {

using Kind = CharacteristicKind;

CharacteristicSpec spec_of(Kind kind) {
    CharacteristicSpec spec;
    spec.kind = kind;
    spec.label = to_string(kind);
    return spec;
}

TEST(NominalMeasures, KnowWhatWasAskedOfTheirSectionAndNothingElse) {
    const synthetic::Shape shape;
    const synthetic::Section section(shape);
    const auto nominal = fitting::analyse_nominal(synthetic::positions(section.contour()));
    ASSERT_TRUE(nominal);
    auto elsewhere = spec_of(Kind::axial_chord), given = spec_of(Kind::stagger);
    elsewhere.sections = {3};
    given.nominal = 0.5;
    const std::vector<CharacteristicSpec> asked{
        spec_of(Kind::chord), spec_of(Kind::max_thickness), spec_of(Kind::le_radius), elsewhere, given,
        spec_of(Kind::twist)};
    const NominalMeasures measures(*nominal, 2, asked);

    const auto fit = section_of_nominal(*nominal);
    fitting::MeasuredSection measured(fit);
    for (const auto kind : {Kind::chord, Kind::max_thickness}) {
        const auto* const known = measures.find(spec_of(kind));
        ASSERT_NE(known, nullptr);
        ASSERT_TRUE(*known);
        EXPECT_EQ(**known, measure_of(spec_of(kind), measured)->value);
    }
    ASSERT_NE(measures.find(spec_of(Kind::le_radius)), nullptr);
    EXPECT_FALSE(*measures.find(spec_of(Kind::le_radius))) << "it depends on the form that the part's points support";
    EXPECT_EQ(measures.find(elsewhere), nullptr) << "of another section";
    EXPECT_EQ(measures.find(given), nullptr) << "the part file gives it";
    EXPECT_EQ(measures.find(spec_of(Kind::twist)), nullptr) << "its nominal is 0";
    EXPECT_EQ(measures.find(spec_of(Kind::area)), nullptr) << "not asked for";
    EXPECT_EQ(measures.contour().size(), fit.contour.size());
}

}  // namespace
}  // namespace cmm::acquisition
