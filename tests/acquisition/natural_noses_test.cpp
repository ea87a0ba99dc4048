// SPDX-License-Identifier: Apache-2.0
/// Blades whose curvature falls from the nose on and jumps nowhere, through the whole judgement of a part: what the
/// other sections know goes into the contour beside a nose, too, where a section's own points are few.
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

#include "acquisition/part_judge.hpp"
#include "acquisition/section_finisher.hpp"
#include "support/natural_blade.hpp"

namespace cmm::acquisition {
namespace {

using fitting::RejectReason;
using fitting::natural::Blade;

constexpr std::size_t section_count = 25;
constexpr double section_step_mm = 4.0, ball_mm = 1.0;

struct Errors {
    double squares = 0.0, largest_mm = 0.0;
    std::size_t count = 0;

    void add(double error_mm) {
        squares += error_mm * error_mm;
        largest_mm = std::max(largest_mm, std::abs(error_mm));
        ++count;
    }
    double rms_mm() const { return std::sqrt(squares / static_cast<double>(count)); }
};

struct MeasuredBlade {
    Blade blade;
    std::vector<Blade::Scan> scans;
    std::vector<SectionResult> sections;

    /// `more_bad_mm`: of the last points before the LE's nose, in section 12.
    MeasuredBlade(std::uint64_t seed, bool slender, double edge_radii, double le_share = 1.0,
                  const std::vector<double>& more_bad_mm = {})
        : blade(seed, slender, le_share) {
        PartJudge judge;
        for (std::size_t k = 0; k < section_count; ++k) {
            scans.push_back(blade.scan(100 * seed + k, ball_mm, edge_radii));
            if (k == 12) spoil(scans.back(), more_bad_mm);
            SectionSetup setup;
            setup.index = k;
            setup.z_mm = section_step_mm * static_cast<double>(k);
            setup.le_hint_mm = blade.le();
            std::vector<RecordedPoint> points;
            for (const auto& centre : scans.back().centres) {
                auto& point = points.emplace_back();
                point.sequence = points.size();
                point.centre_mm << centre, setup.z_mm;
            }
            judge.finish(setup, std::move(points));
        }
        judge.complete();
        sections = judge.take();
    }

    /// Good points that are left out, and bad ones that are not.
    std::size_t lost() const { return count(true); }
    std::size_t missed() const { return count(false); }

    /// By zones: of sides, or of edges.
    Errors errors(bool of_edges) const {
        Errors errors;
        for (const SectionResult& section : sections)
            for (const auto& point : section.fit->contour)
                if ((point.zone == fitting::Zone::le || point.zone == fitting::Zone::te) == of_edges)
                    errors.add(blade.distance(point.position_mm));
        return errors;
    }

  private:
    static void spoil(Blade::Scan& scan, const std::vector<double>& more_bad_mm) {
        for (std::size_t i = 0; i < more_bad_mm.size(); ++i) {
            const std::size_t at = scan.le_first - more_bad_mm.size() + i;
            const Eigen::Vector2d along = scan.centres[at] - scan.centres[at - 1];
            scan.centres[at] += more_bad_mm[i] * Eigen::Vector2d(along.y(), -along.x()).normalized();
            scan.bad_mm[at] = more_bad_mm[i];
        }
    }
    std::size_t count(bool good) const {
        std::size_t wrong = 0;
        for (const SectionResult& section : sections)
            for (std::size_t i = 0; i < section.points.size(); ++i) {
                const bool is_good = scans[section.index].bad_mm[i] == 0.0;
                const bool is_used = section.points[i].verdict.reason == RejectReason::none;
                wrong += is_good == good && is_used != good ? 1 : 0;
            }
        return wrong;
    }
};

TEST(NaturalNoses, ContoursBesideThemHaveWhatTheOtherSectionsKnow) {
    for (const bool slender : {false, true})
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
            SCOPED_TRACE((slender ? "slender " : "thick ") + std::to_string(seed));
            const MeasuredBlade measured(seed, slender, 4.8);
            const Errors sides = measured.errors(false), edges = measured.errors(true);
            EXPECT_LT(sides.rms_mm(), 0.18e-3);
            EXPECT_LT(sides.largest_mm, 2.2e-3);
            EXPECT_LT(edges.rms_mm(), 0.35e-3);
            EXPECT_LT(edges.largest_mm, 2.0e-3);
        }
}

/// Where the points end to be dense, a run of bad ones may take a good neighbour with it.
TEST(NaturalNoses, GoodPointsBesideBadOnesComeBackWhenAllSectionsAreThere) {
    std::size_t lost = 0;
    for (const std::uint64_t seed : {6, 14}) {
        SCOPED_TRACE(seed);
        const MeasuredBlade measured(seed, true, 1.8, 0.4);
        EXPECT_EQ(measured.missed(), 0U);
        EXPECT_LT(measured.errors(false).largest_mm, 5e-3);
        lost += measured.lost();
        for (const SectionResult& section : measured.sections)
            for (const auto& point : section.points)
                EXPECT_FALSE(point.verdict.kept) << "by the other sections, not by an operator";
    }
    EXPECT_LE(lost, 5U);
}

/// Who follows the events hears of the points that come back: what was told and not taken back is what is left out.
TEST(NaturalNoses, PointsThatComeBackAreAnnounced) {
    const MeasuredBlade measured(13, true, 1.8, 0.4);
    core::ManualClock clock;
    EventHub events{clock};
    std::size_t rejected = 0, restored = 0;
    events.listen([&](const Event& event) {
        rejected += event.kind == EventKind::point_rejected ? 1 : 0;
        restored += event.kind == EventKind::point_restored ? 1 : 0;
    });
    std::deque<SectionSetup> setups;  // the sections refer to them
    Workers workers{1};
    SectionFinisher finisher(events, clock, workers);
    for (const SectionResult& done : measured.sections) {
        SectionSetup& setup = setups.emplace_back();
        setup.index = done.index;
        setup.z_mm = done.z_mm;
        setup.le_hint_mm = measured.blade.le();
        auto points = done.points;
        for (auto& point : points)
            point.verdict = {};
        auto section = std::make_unique<LiveSection>(setup, 1e-4, core::PartFromMachine(), 0);
        section->restore(std::move(points));
        finisher.submit(std::move(section));
    }
    finisher.complete();
    std::size_t left_out = 0;
    for (const SectionResult& section : finisher.take_all())
        left_out += section.rejected();
    EXPECT_GE(restored, 4U);
    EXPECT_EQ(rejected, restored + left_out);
}

/// Two points are no dent, however much the one is farther off than the other.
TEST(NaturalNoses, TwoBadPointsBesideTheNoseHaveNoFlanks) {
    const MeasuredBlade measured(1, true, 1.8, 0.25, {0.087, 0.387});
    EXPECT_EQ(measured.missed(), 0U);
    EXPECT_LT(measured.errors(false).largest_mm, 5e-3);
}

}  // namespace
}  // namespace cmm::acquisition
