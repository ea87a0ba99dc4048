// SPDX-License-Identifier: Apache-2.0
#include "acquisition/run_results.hpp"

#include <cmath>
#include <deque>
#include <utility>

#include "acquisition/part_characteristics.hpp"
#include "acquisition/part_judge.hpp"
#include "acquisition/section_setup.hpp"
#include "acquisition/traceability.hpp"

namespace cmm::acquisition {
namespace {

/// Points scatter in z with the probe's noise: a section that lies on a height of the plan is at that height.
double planned_height(double z_mm, const std::vector<double>& heights_mm) {
    constexpr double scatter_mm = 0.02;
    for (const double height : heights_mm) {
        if (std::abs(height - z_mm) <= scatter_mm) return height;
    }
    return z_mm;
}

}  // namespace

core::Result<PartResult> results_of_points(const std::vector<PointSection>& sections, double ball_radius_mm,
                                           const PartFile* part, OperatorChoice choice) {
    PartFile bare;
    bare.name = "points";
    PartFile used = part != nullptr ? *part : bare;
    used.stylus.radius_mm = ball_radius_mm;
    const auto nominal = load_nominal(used.nominal);
    if (!nominal) return tl::unexpected(nominal.error());
    PartResult result;
    result.sources = sources_of(used);
    result.part_name = used.name;
    result.part_serial = used.serial;
    result.machine = "recorded points";
    result.ball_radius_mm = ball_radius_mm;
    result.has_nominal = *nominal != nullptr;
    result.decision_rule = used.gate.rule.worded();
    result.uncertainty = used.uncertainty;
    std::uint64_t sequence = 0;
    std::deque<SectionSetup> setups;
    PartJudge judge;
    for (std::size_t i = 0; i < sections.size(); ++i) {
        auto setup =
            make_section_setup(used, nominal->get(), i, planned_height(sections[i].z_mm(), used.scan.heights_mm));
        if (!setup) return tl::unexpected(setup.error());
        setup->name = sections[i].name;
        std::vector<RecordedPoint> points;
        points.reserve(sections[i].points_mm.size());
        for (std::size_t k = 0; k < sections[i].points_mm.size(); ++k) {
            RecordedPoint point;
            point.sequence = sections[i].sequences.empty() ? ++sequence : sections[i].sequences[k];
            point.centre_mm = sections[i].points_mm[k];
            point.flags = sections[i].flags.empty() ? std::uint16_t{0} : sections[i].flags[k];
            point.pass = sections[i].passes.empty() ? std::uint8_t{0} : sections[i].passes[k];
            if ((point.flags & core::sample_flag::no_contact) != 0)
                point.verdict.reason = fitting::RejectReason::no_contact;
            points.push_back(point);
        }
        choice.apply(points);
        judge.finish(setups.emplace_back(std::move(*setup)), std::move(points));
    }
    judge.complete();
    result.sections = judge.take();
    add_part_characteristics(used.gate.characteristics, used.gate.rule, result);
    if (auto status = choice.all_found(); !status) return tl::unexpected(status.error());
    return result;
}

}  // namespace cmm::acquisition
