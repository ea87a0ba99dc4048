// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/part_file.hpp"
#include "acquisition/part_judge.hpp"
#include "bench/bench.hpp"
#include "core/processor_time.hpp"
#include "core/rng.hpp"
#include "tests/acquisition/decision_subject.hpp"

namespace cmm::bench {
namespace {

namespace families = fitting::families;
using acquisition::decisions::planned_lap;
using acquisition::decisions::setup_of;

constexpr std::size_t points_of_section = 2000;
constexpr int blades = 8;
constexpr double sigma_mm = 1e-3, bad_share = 0.01, bad_low_mm = 0.020, bad_high_mm = 0.400;

double processor_ms() {
    return 1e3 * core::seconds(core::thread_processor_time());
}

/// A section as it comes from the probe, with what the demo part asks of it.
struct Measured {
    acquisition::SectionSetup setup;
    std::vector<acquisition::RecordedPoint> points;
};

Measured measured(acquisition::SectionSetup setup, std::uint64_t seed) {
    Measured section{std::move(setup), {}};
    core::Rng rng(seed);
    for (const auto& place : planned_lap(section.setup, points_of_section).points) {
        auto& point = section.points.emplace_back();
        point.sequence = section.points.size();
        const double bad = rng.uniform() < bad_share ? rng.uniform(bad_low_mm, bad_high_mm) : 0.0;
        point.centre_mm = place.centre_mm + (sigma_mm * rng.normal() + bad) * place.normal;
    }
    return section;
}

/// A prismatic blade with the demands of the demo part.
Measured measured(families::Family family, std::uint64_t seed, const acquisition::GateSpec& gate) {
    auto setup = setup_of(families::make(family, seed), 0.0);
    setup.fitting = {};  // the points say what the edges are
    setup.gate = gate;
    setup.nominal_measures =
        std::make_shared<const acquisition::NominalMeasures>(setup.nominal->section, 0, setup.gate.characteristics);
    return measured(std::move(setup), seed);
}

/// Heights of the demo part.
core::Result<std::vector<Measured>> demo_sections(const acquisition::PartFile& part) {
    const auto nominal = acquisition::load_nominal(part.nominal);
    if (!nominal) return tl::unexpected(nominal.error());
    std::vector<Measured> sections;
    for (const double z_mm : part.scan.heights_mm) {
        auto setup = acquisition::make_section_setup(part, nominal->get(), sections.size(), z_mm);
        if (!setup) return tl::unexpected(setup.error());
        sections.push_back(measured(std::move(*setup), sections.size()));
    }
    return sections;
}

/// More than the caches hold, so that the next section finds nothing there.
void forget_caches() {
    static std::vector<unsigned char> far_away(std::size_t{64} << 20);
    for (std::size_t i = 0; i < far_away.size(); i += 64)
        ++far_away[i];
}

/// What a section takes until its contour is told (SectionFinal), and until its numbers are (GateDecision).
struct Judgement {
    std::vector<double> told_ms, decided_ms;
};

Judgement judgement(const std::vector<Measured>& sections, int repeats, bool cold) {
    Judgement out;
    for (int k = 0; k < repeats; ++k) {
        for (const auto& section : sections) {
            auto points = section.points;
            acquisition::PartJudge judge;
            if (cold) forget_caches();
            const double begun = processor_ms();
            auto closed = judge.close(section.setup, std::move(points));
            if (!closed.has_contour()) return {};
            out.told_ms.push_back(processor_ms() - begun);
            judge.take_over(section.setup, acquisition::judge_laid(std::move(closed), section.setup));
            out.decided_ms.push_back(processor_ms() - begun);
        }
    }
    return out;
}

/// Smallest, median and 99th in a hundred.
Spread quantiles(std::vector<double> ms) {
    if (ms.empty()) return {};
    std::sort(ms.begin(), ms.end());
    return {ms.front(), ms[ms.size() / 2], ms[ms.size() * 99 / 100]};
}

}  // namespace

void bench_section_final(const std::string& config_folder) {
    const auto part = acquisition::load_part_file(config_folder + "/parts/demo.toml");
    if (!part) return;
    const auto of = [](const std::string& what, const std::vector<Measured>& sections) {
        const auto warm = judgement(sections, 50, false), cold = judgement(sections, 12, true);
        print("contour of " + std::to_string(sections.front().points.size()) + " points, " + what + " (min p50 p99)",
              quantiles(warm.told_ms), "ms of CPU", "5 ms");
        print("  with empty caches", quantiles(cold.told_ms), "ms of CPU", "5 ms");
        print("  and its decision", quantiles(warm.decided_ms), "ms of CPU", "");
        print("  with empty caches", quantiles(cold.decided_ms), "ms of CPU", "");
    };
    for (const auto family : families::all_families) {
        std::vector<Measured> sections;
        for (int seed = 1; seed <= blades; ++seed)
            sections.push_back(measured(family, static_cast<std::uint64_t>(seed), part->gate));
        of(families::to_string(family), sections);
    }
    if (const auto sections = demo_sections(*part)) of("demo part", *sections);
}

}  // namespace cmm::bench
