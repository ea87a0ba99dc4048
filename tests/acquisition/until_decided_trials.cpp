// SPDX-License-Identifier: Apache-2.0
#include "tests/acquisition/until_decided_trials.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "acquisition/live_section.hpp"
#include "support/section_truth.hpp"

namespace cmm::acquisition::decisions {
namespace {

using fitting::families::Blade;
using fitting::families::Vec2;
using Height = std::function<double(double)>;

double none(double /*t*/) {
    return 0.0;
}

/// One characteristic, its true value being the upper limit; nothing else is judged.
SectionSetup with_size_at_limit(SectionSetup setup, CharacteristicKind kind, double truth) {
    setup.gate.profile_mm.reset();
    setup.gate.edge_profile_mm.reset();
    CharacteristicSpec spec;
    spec.kind = kind;
    spec.label = to_string(kind);
    spec.nominal = truth;
    spec.above = 0.0;
    setup.gate.characteristics = {spec};
    return setup;
}

struct Case {
    std::string name;
    std::vector<std::string> judged;
    SectionSetup setup;
    Height height_mm;
};

Case case_of(const Blade& blade, std::uint64_t turn) {
    const auto size = [&](CharacteristicKind kind, double truth) {
        const std::string name(to_string(kind));
        return Case{name + ", upper", {name}, with_size_at_limit(setup_of(blade, 0.0), kind, truth), none};
    };
    const auto swollen = [&](const char* where, double width) {
        return Case{where, {"profile_suction"}, setup_of(blade, 0.0), [width](double t) {
                        return half_zone_mm * swelling(t, width);
                    }};
    };
    const std::vector<std::string> zones{"profile_le", "profile_suction", "profile_te", "profile_pressure"};
    switch (turn % 7) {
        case 0:
            return {", all of it outwards", zones, setup_of(blade, half_zone_mm), none};
        case 1:
            return {", all of it inwards", zones, setup_of(blade, -half_zone_mm), none};
        case 2:
            return swollen(", at one place", 0.08);
        case 3:
            return swollen(", at a narrow place", 0.02);
        case 4:
            return size(CharacteristicKind::le_radius, blade.le().nose_radius());
        default:
            break;
    }
    const fitting::section_truth::SectionTruth truth(fitting::section_truth::of_family(blade));
    if (turn % 7 == 5) return size(CharacteristicKind::chord, (truth.tail() - truth.nose()).norm());
    return size(CharacteristicKind::max_thickness, truth.thickest().diameter);
}

}  // namespace

Probe::Probe(const Blade& blade, Height height_mm, double sigma_mm, std::uint64_t seed)
    : blade_(blade), height_mm_(std::move(height_mm)), sigma_mm_(sigma_mm), rng_(core::Rng::keyed(seed, 0xA6A1, 0)) {}

void Probe::measure(std::span<const drivers::PathPoint> path, std::uint8_t pass, std::vector<RecordedPoint>& points) {
    for (const auto& place : path) {
        const double t = place_of(blade_, place);
        const auto jet = blade_.at(t);
        const Vec2 centre = jet.position + (ball_mm + height_mm_(t) + sigma_mm_ * rng_.normal()) * jet.normal();
        RecordedPoint point;
        point.sequence = points.size() + 1;
        point.centre_mm = {centre.x(), centre.y(), 0.0};
        point.pass = pass;
        points.push_back(point);
    }
}

Measured measure_until_decided(const SectionSetup& setup, const PlannedPath& lap, const UntilDecided& bound,
                               Probe& probe, bool early_stop) {
    Measured out;
    std::vector<RecordedPoint> points;
    probe.measure(lap.points, 0, points);
    out.seconds = lap.duration_s;
    if (early_stop) {
        LiveSection live(setup, 1.0, core::PartFromMachine(), lap.points.size());
        for (std::size_t i = 0; i < points.size() && !live.exceedance(); ++i)
            live.restore({points[i]});
        if (live.exceedance()) {
            out.early = true;
            out.seconds *= static_cast<double>(live.points().size()) / static_cast<double>(points.size());
            points.resize(live.points().size());
        }
    }
    SectionJudge judge;
    out.result = judge.finish(setup, points);
    double spent_s = 0.0;
    while (!out.early && out.passes < bound.passes && out.result.decision() == Decision::undecided) {
        const auto again = plan_again(out.result, setup, lap, bound);
        if (!again) break;
        ++out.passes;
        for (const auto& stretch : again->stretches)
            probe.measure(stretch, static_cast<std::uint8_t>(out.passes), points);
        spent_s += again->duration_s;
        out.result = judge.finish(setup, points);
    }
    out.points = points.size();
    out.seconds += spent_s;
    return out;
}

Table run_until_decided(const Task& task, const UntilDecided& bound) {
    Table table;
    for (std::uint64_t seed = task.first_seed; seed < task.first_seed + task.blades; ++seed) {
        const Blade blade = fitting::families::make(task.family, seed);
        for (const double sigma_mm : task.sigmas_mm) {
            Case one = case_of(blade, seed);
            one.setup.gate.rule.looks = bound.passes + 1;
            const auto lap = planned_lap(one.setup, task.points);
            Probe probe(blade, one.height_mm, sigma_mm, seed);
            const auto measured = measure_until_decided(one.setup, lap, bound, probe, false);
            for (const auto& name : one.judged) {
                const auto* c = measured.result.find(name);
                const std::string row = one.judged.size() > 1 || one.name.front() == ',' ? name + one.name : one.name;
                table[row].count(c != nullptr ? c->decision : Decision::not_evaluable);
            }
            Rates& all = table["measured again (accepted: with one pass, rejected: with more)"];
            ++all.trials;
            all.accepted += measured.passes == 1 ? 1 : 0;
            all.rejected += measured.passes > 1 ? 1 : 0;
        }
    }
    return table;
}

std::vector<Cost> compare_costs(std::uint64_t first_seed, std::uint64_t blades, double sigma_mm) {
    struct Way {
        const char* name;
        std::size_t points, passes;
        bool early;
    };
    constexpr std::array ways{Way{"300 points", 300, 0, false},
                              Way{"600 points", 600, 0, false},
                              Way{"1 200 points", 1200, 0, false},
                              Way{"2 400 points", 2400, 0, false},
                              Way{"4 800 points", 4800, 0, false},
                              Way{"600 points, early stop", 600, 0, true},
                              Way{"300 points, until decided", 300, 2, true},
                              Way{"600 points, until decided", 600, 2, true}};
    std::vector<Cost> costs;
    for (const auto& way : ways)
        costs.push_back({way.name});
    const auto& families = fitting::families::all_families;
    for (std::uint64_t seed = first_seed; seed < first_seed + blades; ++seed) {
        const Blade blade = fitting::families::make(families[seed % families.size()], seed);
        core::Rng rng = core::Rng::keyed(seed, 0xC057, 0);
        const double kind = rng.uniform();
        const double share = kind < 0.7    ? rng.uniform(0.0, 0.8)
                             : kind < 0.85 ? rng.uniform(1.2, 2.0)
                                           : rng.uniform(0.85, 1.15);
        const double top_mm = (rng.uniform() < 0.5 ? 1.0 : -1.0) * share * half_zone_mm;
        const SectionSetup setup = setup_of(blade, 0.0);
        for (std::size_t k = 0; k < ways.size(); ++k) {
            SectionSetup judged = setup;
            UntilDecided bound;
            bound.passes = ways[k].passes;
            judged.gate.rule.looks = bound.passes + 1;
            const auto lap = planned_lap(judged, ways[k].points);
            Probe probe(
                blade, [top_mm](double t) { return top_mm * swelling(t, 0.08); }, sigma_mm, seed);
            const auto measured = measure_until_decided(judged, lap, bound, probe, ways[k].early);
            Cost& cost = costs[k];
            const auto decision = measured.result.decision();
            ++cost.sections;
            cost.points += measured.points;
            cost.seconds += measured.seconds;
            cost.early += measured.early ? 1 : 0;
            cost.again += measured.passes > 0 ? 1 : 0;
            cost.undecided += decision == Decision::undecided ? 1 : 0;
            const bool conforms = share <= 1.0;
            cost.wrong += decision == (conforms ? Decision::reject : Decision::accept) ? 1 : 0;
        }
    }
    return costs;
}

}  // namespace cmm::acquisition::decisions
