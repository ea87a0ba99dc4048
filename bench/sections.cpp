// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <numbers>

#include "acquisition/journal.hpp"
#include "acquisition/live_section.hpp"
#include "bench/bench.hpp"
#include "core/rng.hpp"
#include "core/units.hpp"
#include "fitting/section.hpp"

namespace cmm::bench {
namespace {

constexpr double ball_mm = 1.0;
constexpr double lsb_mm = 1e-4;

/// Ball centres round an ellipse-edged profile of 60 mm chord, noise 1 um along the normal; from its formula.
Eigen::Vector2d centre(double turn, core::Rng& rng) {
    const double t = 2.0 * std::numbers::pi * turn;
    constexpr double a = 30.0;
    constexpr double b = 3.0;
    const Eigen::Vector2d normal = Eigen::Vector2d(b * std::cos(t), a * std::sin(t)).normalized();
    return Eigen::Vector2d(a * std::cos(t), b * std::sin(t)) + (ball_mm + 1e-3 * rng.normal()) * normal;
}

std::vector<Eigen::Vector2d> section(std::size_t n) {
    core::Rng rng(7);
    std::vector<Eigen::Vector2d> centres;
    for (std::size_t i = 0; i < n; ++i)
        centres.push_back(centre(static_cast<double>(i) / static_cast<double>(n), rng));
    return centres;
}

std::vector<core::Sample> samples(std::size_t n, std::uint64_t first_sequence) {
    core::Rng rng(first_sequence);
    std::vector<core::Sample> all(n);
    for (std::size_t i = 0; i < n; ++i) {
        const auto p = centre(static_cast<double>(i % 2000) / 2000.0, rng);
        all[i].sequence = first_sequence + i;
        all[i].path = 1;
        all[i].machine_time_us = static_cast<std::int64_t>((first_sequence + i) * 1000);
        all[i].counts = {core::counts_from_mm(p.x(), lsb_mm), core::counts_from_mm(p.y(), lsb_mm), 100000};
    }
    return all;
}

void bench_fit() {
    for (const std::size_t n : {500U, 2000U, 20000U}) {
        const auto centres = section(n);
        fitting::SectionOptions options;
        options.ball_radius_mm = ball_mm;
        bool good = true;
        const auto spread = time_of(15, [&] { good = good && fitting::fit_section(centres, {}, options).has_value(); });
        print("section fit, " + std::to_string(n) + " points" + (good ? "" : " (FAILED)"),
              {spread.low * 1e3, spread.median * 1e3, spread.high * 1e3}, "ms", n == 2000U ? "< 20 ms" : "");
    }
}

void bench_live_section() {
    const auto batch = samples(2000, 1);
    acquisition::SectionSetup setup;
    const auto live = time_of(25, [&] {
        acquisition::LiveSection section(setup, lsb_mm, core::PartFromMachine(), 2000);
        for (std::size_t i = 0; i < batch.size(); i += 14)
            section.add(std::span(batch).subspan(i, std::min<std::size_t>(14, batch.size() - i)));
    });
    print("live section, a sample", {live.low / 2000 * 1e6, live.median / 2000 * 1e6, live.high / 2000 * 1e6}, "us",
          "");
}

void bench_journal() {
    const auto folder = std::filesystem::temp_directory_path() / "cmmlive-bench-journal";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    const double before = peak_memory_mb();
    const auto spread = time_of(1, [&] {
        auto journal = acquisition::Journal::create(folder / "run.cmmrun", {});
        if (!journal) return;
        acquisition::JournalPath path;
        path.path = 1;
        (void)(*journal)->begin_path(path);
        for (std::uint64_t first = 1; first <= 1'000'000; first += 2000) {
            if (!(*journal)->append(samples(2000, first))) return;
        }
        (void)(*journal)->flush();
    });
    const double rate = 1e6 / spread.median;
    print("journal, a million samples, durable", {rate, rate, rate}, "samples/s", "");
    const double size = static_cast<double>(std::filesystem::file_size(folder / "run.cmmrun")) / 1e6;
    print("run file of a million samples", {size, size, size}, "MB", "");
    const double peak = peak_memory_mb();
    print("peak memory, a million samples (before: " + std::to_string(static_cast<int>(before)) + " MB)",
          {peak, peak, peak}, "MB", "");
    std::filesystem::remove_all(folder);
}

}  // namespace

void bench_sections() {
    bench_live_section();
    bench_fit();
    bench_journal();
}

}  // namespace cmm::bench
