// SPDX-License-Identifier: Apache-2.0
/// Bad points that only the other sections betray, through the whole judgement of a part.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/section_finisher.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::acquisition {
namespace {

namespace families = fitting::families;
using fitting::RejectReason;

/// A fan blade of 25 sections: in the tenth one three bad points of 24, 102 and 20 um, where a side begins, pass for
/// its form.
struct StraySections : ::testing::Test {
    static constexpr std::size_t stray = 9;
    families::TwistedBlade blade;
    families::BladeRows rows;
    std::deque<SectionSetup> setups;

    explicit StraySections(std::uint64_t seed = 63, double sigma_mm = 1e-3) : blade(families::Family::fan, seed) {
        families::ScanOptions scanning;
        scanning.seed = seed;
        scanning.sigma_mm = sigma_mm;
        rows = families::scan_rows(blade, 25, 2.0, blade.height() - 2.0, scanning);
        for (std::size_t k = 0; k < rows.rows.size(); ++k) {
            SectionSetup& setup = setups.emplace_back();
            setup.index = k;
            setup.z_mm = rows.heights[k];
            setup.le_hint_mm = blade.outline(setup.z_mm).le().nose;
        }
    }
    std::vector<RecordedPoint> points(std::size_t k) const {
        std::vector<RecordedPoint> points;
        for (const auto& centre : rows.rows[k]) {
            auto& point = points.emplace_back();
            point.sequence = points.size();
            point.centre_mm = centre;
        }
        return points;
    }
    double largest_error_mm(const SectionResult& section) const {
        const auto truth = blade.section(section.z_mm);
        double largest = 0.0;
        for (const auto& p : section.fit->contour)
            largest = std::max(largest, std::abs(truth.closest(p.position_mm).distance));
        return largest;
    }
    /// Points of 20 um and more that are used.
    std::size_t missed(const SectionResult& section) const {
        std::size_t count = 0;
        for (std::size_t i = 0; i < section.points.size(); ++i)
            count +=
                std::abs(rows.bad[section.index][i]) >= 0.02 && section.points[i].verdict.reason == RejectReason::none
                    ? 1
                    : 0;
        return count;
    }
};

TEST_F(StraySections, AreFittedAnewWithoutThemWhenAllSectionsAreThere) {
    PartJudge judge;
    for (std::size_t k = 0; k < setups.size(); ++k) {
        const auto& alone = judge.finish(setups[k], points(k));
        if (k != stray) continue;
        EXPECT_EQ(missed(alone), 3U);
        EXPECT_GT(largest_error_mm(alone), 9e-3);
    }
    judge.complete();
    const auto sections = judge.take();
    ASSERT_EQ(sections.size(), setups.size());
    for (const auto& section : sections) {
        SCOPED_TRACE(section.index);
        EXPECT_EQ(missed(section), 0U);
        EXPECT_LT(largest_error_mm(section), 2e-3);
        EXPECT_EQ(section.compensation.state, Compensation::State::final);
    }
    const auto& points = sections[stray].points;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double bad_mm = rows.bad[stray][i];
        if (bad_mm == 0.0 || points[i].verdict.reason != RejectReason::fit_residual) continue;
        EXPECT_NEAR(points[i].verdict.residual_mm, bad_mm, 3e-3) << "from what the others foretell";
    }
    // The change since it was provisional holds what they had done.
    EXPECT_GT(sections[stray].compensation.change_mm, 5e-3);
}

/// Who follows the events hears of them, once.
TEST_F(StraySections, AreAnnouncedWithTheirRevision) {
    core::ManualClock clock;
    EventHub events{clock};
    std::vector<Event> heard;
    events.listen([&](const Event& event) {
        if (event.kind == EventKind::point_rejected) heard.push_back(event);
    });
    Workers workers{1};
    SectionFinisher finisher(events, clock, workers);
    for (std::size_t k = 0; k < setups.size(); ++k) {
        auto section = std::make_unique<LiveSection>(setups[k], 1e-4, core::PartFromMachine(), 0);
        section->restore(points(k));
        finisher.submit(std::move(section));
    }
    finisher.complete();
    const auto sections = finisher.take_all();
    std::size_t strays = 0;
    for (const Event& event : heard) {
        const bool of_section = event.payload.find("\"section\":" + std::to_string(stray) + ",") != std::string::npos;
        strays += of_section && event.payload.find("fit_residual") != std::string::npos ? 1 : 0;
    }
    EXPECT_EQ(strays, 3U);
    std::size_t rejected = 0;
    for (const auto& section : sections)
        rejected += section.rejected();
    EXPECT_GE(heard.size(), rejected);
}

/// Whatever the others say: no point is left out to make an accepted section of a rejected one.
TEST_F(StraySections, StayAsTheyAreWhereTheyAreRejected) {
    CharacteristicSpec chord;
    chord.label = "chord";
    chord.nominal = 1.0;
    chord.below = -1e-3;
    chord.above = 1e-3;
    setups[stray].gate.characteristics.push_back(chord);
    PartJudge judge;
    for (std::size_t k = 0; k < setups.size(); ++k)
        judge.finish(setups[k], points(k));
    judge.complete();
    const auto sections = judge.take();
    EXPECT_EQ(sections[stray].decision(), Decision::reject);
    EXPECT_EQ(missed(sections[stray]), 3U);
}

/// Completed while sections were missing, and again with all of them: as if all had come at once.
TEST_F(StraySections, ItDoesNotMatterHowOftenThePartIsCompleted) {
    PartJudge twice, once;
    for (std::size_t k = 0; k < setups.size(); ++k) {
        twice.finish(setups[k], points(k));
        once.finish(setups[k], points(k));
        if (k == 14) twice.complete(false);
    }
    twice.complete();
    once.complete();
    const auto a = twice.take(), b = once.take();
    for (std::size_t k = 0; k < setups.size(); ++k) {
        ASSERT_EQ(a[k].fit->contour.size(), b[k].fit->contour.size());
        for (std::size_t i = 0; i < a[k].fit->contour.size(); ++i)
            ASSERT_EQ(a[k].fit->contour[i].position_mm, b[k].fit->contour[i].position_mm) << k << " " << i;
    }
}

/// Beside an edge the lowest section has left out three bad points of 28, 73 and 28 um and the good one behind them.
struct LeftOutWithBadOnes : StraySections {
    LeftOutWithBadOnes() : StraySections(49) {}
};

TEST_F(LeftOutWithBadOnes, AGoodPointComesBackAlone) {
    constexpr std::size_t section = 0, good = 557;
    PartJudge judge;
    for (std::size_t k = 0; k < setups.size(); ++k) {
        const auto& alone = judge.finish(setups[k], points(k));
        if (k != section) continue;
        EXPECT_NE(alone.points[good].verdict.reason, RejectReason::none);
        EXPECT_EQ(missed(alone), 0U);
    }
    judge.complete();
    const auto results = judge.take();
    EXPECT_EQ(results[section].points[good].verdict.reason, RejectReason::none);
    EXPECT_FALSE(results[section].points[good].verdict.kept) << "by the other sections, not by an operator";
    EXPECT_EQ(missed(results[section]), 0U);
    EXPECT_LT(largest_error_mm(results[section]), 1.5e-3);
}

/// A section beside its TE follows three of 23, 60 and 35 um, the middle one twelve standard deviations high.
struct StraysInMuchNoise : StraySections {
    StraysInMuchNoise() : StraySections(3, 5e-3) {}
};

TEST_F(StraysInMuchNoise, AreFoundAndNoGoodPointWithThem) {
    constexpr std::size_t section = 18;
    PartJudge judge;
    for (std::size_t k = 0; k < setups.size(); ++k) {
        const auto& alone = judge.finish(setups[k], points(k));
        if (k == section) {
            EXPECT_GT(largest_error_mm(alone), 25e-3);
        }
    }
    judge.complete();
    const auto results = judge.take();
    EXPECT_LT(largest_error_mm(results[section]), 8e-3);
    for (const auto& result : results)
        for (std::size_t i = 0; i < result.points.size(); ++i)
            EXPECT_FALSE(result.points[i].verdict.reason == RejectReason::fit_residual &&
                         rows.bad[result.index][i] == 0.0)
                << "section " << result.index << ", point " << i;
}

}  // namespace
}  // namespace cmm::acquisition
