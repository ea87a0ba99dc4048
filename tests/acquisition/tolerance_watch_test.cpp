// SPDX-License-Identifier: Apache-2.0
#include "acquisition/tolerance_watch.hpp"

#include <set>
#include <string>
#include <utility>

#include "acquisition/evaluation.hpp"
#include "acquisition/live_section.hpp"
#include "core/rng.hpp"
#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {
namespace {

constexpr double half_zone_mm = 0.05;  // of the session's part
constexpr double noise_mm = 0.001;

struct ToleranceWatchTest : ::testing::Test {
    SessionPart job{session_part_text("0.4")};
    SectionSetup setup = job.setup(0);
    const PlannedPath& path = job.plan.paths[0];
    core::Rng rng{20261122};

    /// Thicker by `thicken_mm` from `first` on, for `count` points; the others lie where they should, all with noise.
    std::vector<core::Sample> samples(double thicken_mm, std::size_t first, std::size_t count) {
        std::vector<core::Sample> made;
        for (std::size_t i = 0; i < path.points.size(); ++i) {
            const auto& point = path.points[i];
            const double off_mm = (i >= first && i < first + count ? thicken_mm : 0.0) + noise_mm * rng.normal();
            made.push_back(sample_at(i + 1, 1, point.centre_mm + off_mm * point.normal));
        }
        return made;
    }
    std::vector<core::Sample> all(double thicken_mm) { return samples(thicken_mm, 0, path.points.size()); }
    std::optional<Exceedance> seen(const std::vector<core::Sample>& measured) const {
        LiveSection live(setup, test_lsb_mm, core::PartFromMachine(), measured.size());
        live.add(measured);
        return live.exceedance();
    }
    std::size_t first_on(fitting::Zone zone) const {
        const auto& nominal = setup.nominal->section;
        for (std::size_t i = 0; i < path.points.size(); ++i) {
            const auto foot = nominal.curve().closest(path.points[i].centre_mm.head<2>());
            if (nominal.zone_at(foot.s_mm) == zone) return i;
        }
        ADD_FAILURE() << "no point there";
        return 0;
    }
};

TEST_F(ToleranceWatchTest, APartAtItsLimitIsNotCalledOut) {
    for (int section = 0; section < 100; ++section) {
        EXPECT_FALSE(seen(all(half_zone_mm))) << section;
        EXPECT_FALSE(seen(all(-half_zone_mm))) << section;
    }
}

/// What the machine does alike to all points no row of points averages away.
TEST_F(ToleranceWatchTest, WhatTheMachineSharesIsKeptBack) {
    fitting::SystematicErrors errors;
    errors.ball_mm = 0.002;
    errors.form_mm = 0.001;
    const fitting::ErrorFields fields(errors, setup.z_mm);
    // 6 um beyond the limit is certain for a machine without errors, and what 2.7 standard deviations of this one make.
    const auto measured = all(half_zone_mm + 0.006), far_out = all(half_zone_mm + 0.02);
    EXPECT_TRUE(seen(measured));
    setup.fields = fields;
    EXPECT_FALSE(seen(measured));
    const auto found = seen(far_out);
    ASSERT_TRUE(found);
    EXPECT_GT(found->guard_mm, 3.0 * std::hypot(0.002, 0.001));
    EXPECT_LT(found->guard_mm, 0.02);
    // An expansion that is known and not corrected is kept back as it is.
    fitting::SystematicErrors warm;
    warm.known_expansion = 1e-2;
    setup.fields = fitting::ErrorFields(warm, setup.z_mm);
    EXPECT_FALSE(seen(measured));
}

TEST_F(ToleranceWatchTest, APartThatIsOutIsKnownLongBeforeItsSectionIsComplete) {
    for (const double thicken_mm : {0.066, -0.06}) {
        const auto measured = all(thicken_mm);
        LiveSection live(setup, test_lsb_mm, core::PartFromMachine(), measured.size());
        live.add(std::span(measured).first(40));
        ASSERT_TRUE(live.exceedance()) << thicken_mm;
        EXPECT_NEAR(live.exceedance()->deviation_mm, thicken_mm, 4.0 * noise_mm);
        EXPECT_EQ(live.exceedance()->limit_mm, 2.0 * half_zone_mm);
        EXPECT_GT(live.exceedance()->guard_mm, 0.0);
        EXPECT_LT(live.exceedance()->guard_mm, 0.013);
    }
}

TEST_F(ToleranceWatchTest, ABumpIsFoundWhereItIs) {
    const auto first = first_on(fitting::Zone::pressure) + 20;
    const auto found = seen(samples(0.08, first, 24));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->zone, fitting::Zone::pressure);
    EXPECT_GT(found->sequence, first);
    EXPECT_LE(found->sequence, first + 24);
    EXPECT_LT((found->position_mm - path.points[found->sequence - 1].centre_mm.head<2>()).norm(), 1.2);
}

TEST_F(ToleranceWatchTest, RunsOfBadPointsProveNothing) {
    for (std::size_t count = 1; count <= 5; ++count)
        for (std::size_t first = 20; first + 40 < path.points.size(); first += 37)
            EXPECT_FALSE(seen(samples(0.3, first, count))) << count << " from " << first;
}

/// Ten places out of tolerance, and more samples there than the watch wants in a row: all but the ten touched nothing.
TEST_F(ToleranceWatchTest, WhereNothingWasTouchedNothingIsSaid) {
    auto measured = samples(0.3, 60, 40);
    ASSERT_TRUE(seen(measured));
    for (std::size_t i = 60; i < 100; ++i)
        if (i % 4 != 0) measured[i].flags = core::sample_flag::no_contact;
    EXPECT_FALSE(seen(measured));
}

TEST_F(ToleranceWatchTest, NothingIsSaidWithoutALimitOrOfAFilteredProfile) {
    const auto measured = all(0.2);
    ASSERT_TRUE(seen(measured));
    const GateSpec limits = setup.gate;
    setup.gate = {};
    EXPECT_FALSE(seen(measured));
    setup.gate = limits;
    fitting::FilterSpec filter;
    filter.kind = fitting::FilterKind::gaussian;
    setup.fitting.filters.of.fill(filter);
    EXPECT_FALSE(seen(measured));
}

TEST_F(ToleranceWatchTest, NearAnEdgeTheWiderLimitCounts) {
    setup.gate.edge_profile_mm = 0.3;
    const auto& nominal = setup.nominal->section;
    const auto found = seen(all(0.1));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->limit_mm, 0.1);  // on a side, far from both edges
    setup.gate.profile_mm.reset();
    setup.gate.edge_profile_mm = 0.1;
    const auto on_edge = seen(all(0.1));
    if (on_edge) {  // the inner half of an edge only: whether eleven points lie there, the pitch decides
        const auto foot = nominal.curve().closest(on_edge->position_mm);
        EXPECT_TRUE(nominal.zone_at(foot.s_mm) == fitting::Zone::le || nominal.zone_at(foot.s_mm) == fitting::Zone::te);
    }
}

TEST_F(ToleranceWatchTest, ASectionThatWasBrokenOffIsRejectedAllTheSame) {
    const auto measured = all(0.08);
    using Names = std::set<std::string>;
    SectionJudge judge;
    // Too little for a contour, and half of one.
    for (const auto& [count, expected] :
         {std::pair{std::size_t{36}, Names{"profile_suction"}},
          {measured.size() / 2, Names{"profile_le", "profile_pressure", "profile_suction"}}}) {
        LiveSection live(setup, test_lsb_mm, core::PartFromMachine(), measured.size());
        live.add(std::span(measured).first(count));
        const auto result = judge.finish(setup, live.points());
        EXPECT_EQ(result.has_contour(), count > 36);
        EXPECT_FALSE(result.all_round());
        EXPECT_EQ(result.decision(), Decision::reject);
        Names rejected;
        for (const auto& c : result.characteristics) {
            if (c.decision != Decision::reject) continue;
            rejected.insert(c.name);
            EXPECT_NEAR(*c.value, 0.16, 8.0 * noise_mm);
            EXPECT_GT(*c.value - *c.guard_reject, *c.upper);
        }
        EXPECT_EQ(rejected, expected);
    }
    EXPECT_EQ(judge.finish(setup, LiveSection(setup, test_lsb_mm, core::PartFromMachine(), 0).points()).decision(),
              Decision::undecided);
}

}  // namespace
}  // namespace cmm::acquisition
