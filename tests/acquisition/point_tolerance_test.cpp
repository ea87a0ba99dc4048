// SPDX-License-Identifier: Apache-2.0
#include "acquisition/point_tolerance.hpp"

#include <gtest/gtest.h>

#include "acquisition/section_figures.hpp"
#include "tests/acquisition/count_of.hpp"
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

TEST(PointTolerance, ThePicturesDrawTheLimitsOfEachPlace) {
    const auto bare = judged_by({-0.1, 0.1}, {-0.1, 0.02}, {});
    const auto limits = limits_along(bare);
    bool narrow = false, wide = false;
    for (std::size_t i = 0; i < limits.size(); ++i) {
        const auto& point = bare.fit->contour[i];
        ASSERT_TRUE(limits[i]);
        EXPECT_DOUBLE_EQ(limits[i]->below_mm, -0.1);
        // A little away from where they change: between two points of the nominal they are in between.
        if (std::abs(point.position_mm.x()) < 1.0 || fitting::Zone::suction != point.zone) continue;
        EXPECT_NEAR(limits[i]->above_mm, point.position_mm.x() > 0.0 ? 0.02 : 0.1, 1e-12);
        (point.position_mm.x() > 0.0 ? narrow : wide) = true;
    }
    EXPECT_TRUE(narrow && wide);
    EXPECT_EQ(count_of(deviation_figure(bare), "class=\"limit\""), 8U) << "above and below in four zones";
    EXPECT_EQ(count_of(whisker_figure(bare), "class=\"band\""), 1U);
    EXPECT_EQ(count_of(whisker_figure(bare), "class=\"whisker-out\""), 1U) << "it is out of narrow ones";
    EXPECT_EQ(count_of(whisker_figure(judged_by({-0.1, 0.1}, {-0.1, 0.1}, {})), "class=\"whisker-out\""), 0U);
    // Where zones have limits, too, the nearer ones hold.
    EvaluationOptions gate;
    gate.profile_mm = 0.05;
    const auto both = judged_by({-0.1, 0.1}, {-0.1, 0.02}, gate);
    const auto nearer = limits_along(both);
    for (std::size_t i = 0; i < nearer.size(); ++i) {
        const auto zone = both.fit->contour[i].zone;
        const bool side = zone == fitting::Zone::suction || zone == fitting::Zone::pressure;
        EXPECT_DOUBLE_EQ(nearer[i]->below_mm, side ? -0.025 : -0.1);
        EXPECT_LE(nearer[i]->above_mm, (side ? 0.025 : 0.1) + 1e-12);
    }
    // What neither has, nobody draws.
    auto none = bare;
    none.tolerances.clear();
    EXPECT_EQ(count_of(deviation_figure(none), "class=\"limit\""), 0U);
    EXPECT_EQ(count_of(whisker_figure(none), "class=\"band\""), 0U);
}

}  // namespace
}  // namespace cmm::acquisition
