// SPDX-License-Identifier: Apache-2.0
#include "acquisition/point_tolerance.hpp"

#include <gtest/gtest.h>

#include "tests/acquisition/synthetic_blade.hpp"

namespace cmm::acquisition {
namespace {

using fitting::Zone;

constexpr double too_much_mm = 0.03;

/// The suction side is too thick by that, nothing else; one half of it (x > 0) may have other limits.
SectionResult judged_by(const PointTolerance& elsewhere, const PointTolerance& there, const EvaluationOptions& options,
                        const SectionAlignment* shared = nullptr) {
    const synthetic::Shape shape;
    const synthetic::Section section(shape);
    auto fit = synthetic::fit_of(section, shape, [](const auto& point) {
        return point.zone == Zone::suction && point.position_mm.x() > 0.0 ? too_much_mm : 0.0;
    });
    SectionResult raw;
    raw.z_mm = 40.0;
    raw.points = synthetic::points_of(fit, 1.0, 40.0, 1, 0, 5);
    NominalContour contour{40.0, {}, 0.0, {}};
    for (const auto& point : section.contour()) {
        contour.points.push_back(point.position_mm);
        const bool here = point.zone == Zone::suction && point.position_mm.x() > 0.0;
        contour.tolerances.push_back(here ? there : elsewhere);
    }
    const auto curve = fitting::analyse_nominal(contour.points).value();
    const ReferenceContour nominal(contour, curve.curve(), 1.0);
    return evaluate_section(std::move(raw), std::move(fit), &nominal, options, &curve, shared);
}

const Characteristic& tolerance_of(const SectionResult& section) {
    const auto* found = section.find(point_tolerance_name);
    EXPECT_NE(found, nullptr);
    static const Characteristic none;
    return found != nullptr ? *found : none;
}

TEST(PointTolerance, EveryPlaceCountsAgainstItsOwnLimits) {
    // Well inside wide limits; out by 10 um of narrow ones; the sign counts.
    const auto inside = tolerance_of(judged_by({-0.1, 0.1}, {-0.1, 0.1}, {}));
    EXPECT_EQ(inside.decision, Decision::accept);
    EXPECT_NEAR(*inside.value, too_much_mm - 0.1, 2e-4);
    const auto out = tolerance_of(judged_by({-0.1, 0.1}, {-0.1, 0.02}, {}));
    EXPECT_EQ(out.decision, Decision::reject);
    EXPECT_NEAR(*out.value, 0.01, 2e-4);
    EXPECT_NE(out.note.find("limits there -0.100 mm to +20.0 um"), std::string::npos) << out.note;
    EXPECT_EQ(tolerance_of(judged_by({-0.1, 0.1}, {-0.01, 0.05}, {})).decision, Decision::accept);
    // What is narrow elsewhere says nothing about the place that is too thick.
    EXPECT_EQ(tolerance_of(judged_by({-0.01, 0.01}, {-0.01, 0.05}, {})).decision, Decision::accept);
}

TEST(PointTolerance, NearALimitItIsUndecidedAndItCountsInTheVerdictOfTheSection) {
    const auto near = judged_by({-0.1, 0.1}, {-0.1, too_much_mm}, {});
    EXPECT_EQ(tolerance_of(near).decision, Decision::undecided);
    EXPECT_EQ(near.decision(), Decision::undecided);
    EXPECT_GT(*tolerance_of(near).guard_accept, 0.0);
    EXPECT_EQ(judged_by({-0.1, 0.1}, {-0.1, 0.02}, {}).decision(), Decision::reject);
    EXPECT_EQ(judged_by({-0.1, 0.1}, {-0.1, 0.1}, {}).decision(), Decision::accept);
}

TEST(PointTolerance, IsTakenAfterTheAlignmentAndLeftOpenUntilTheBladeHasOne) {
    EvaluationOptions options;
    options.alignment.kind = AlignmentKind::section;
    const auto aligned = tolerance_of(judged_by({-0.1, 0.1}, {-0.1, 0.02}, options));
    EXPECT_NE(aligned.method.find("best fit"), std::string::npos) << aligned.method;
    EXPECT_LT(*aligned.value, 0.01 - 0.001);  // the fit takes a part of the deviation away
    options.alignment.kind = AlignmentKind::blade;
    const auto open = tolerance_of(judged_by({-0.1, 0.1}, {-0.1, 0.002}, options));
    EXPECT_EQ(open.decision, Decision::undecided);
    EXPECT_NE(open.note.find("provisional until the whole blade is aligned"), std::string::npos) << open.note;
}

}  // namespace
}  // namespace cmm::acquisition
