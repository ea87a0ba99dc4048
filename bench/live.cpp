// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <chrono>
#include <numbers>
#include <string>
#include <vector>

#include "bench/bench.hpp"
#include "core/rng.hpp"
#include "fitting/live_spline.hpp"

namespace cmm::bench {
namespace {

constexpr std::size_t lap = 2000, laps = 520;
constexpr double noise_mm = 1e-3, bad_mm = 0.1;
constexpr std::size_t every_bad = 70;

/// Ball centres of one lap round an ellipse-edged profile of 60 mm chord, even in its parameter: dense where it turns.
std::vector<fitting::Vec2> one_lap() {
    core::Rng rng(7);
    std::vector<fitting::Vec2> centres;
    for (std::size_t i = 0; i < lap; ++i) {
        const double t = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(lap);
        const fitting::Vec2 at(30.0 * std::cos(t), 3.0 * std::sin(t));
        const fitting::Vec2 normal = fitting::Vec2(3.0 * std::cos(t), 30.0 * std::sin(t)).normalized();
        const double bad = i % every_bad == 0 ? bad_mm : 0.0;
        centres.push_back(at + (1.0 + bad + noise_mm * rng.normal()) * normal);
    }
    return centres;
}

void print_share(const std::string& what, std::vector<double> us, const std::string& target) {
    std::sort(us.begin(), us.end());
    print(what, {us[us.size() / 2], us[us.size() * 99 / 100], us.back()}, "us", target);
}

}  // namespace

/// Single samples, the clock's own time (some 0.03 us) included; a task switch of the machine shows as the largest.
void bench_live() {
    const auto centres = one_lap();
    fitting::LiveSpline curve(fitting::MaterialSide::left);
    std::vector<double> us;
    us.reserve(lap * laps);
    for (std::size_t i = 0; i < lap * laps; ++i) {
        const auto start = std::chrono::steady_clock::now();
        curve.add(i, centres[i % lap]);
        us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
    }
    const std::string target = "p50 < 2, p99 < 20";
    for (const std::size_t first : std::array<std::size_t, 3>{500, 100'000, 1'000'000}) {
        const auto from = us.begin() + static_cast<std::ptrdiff_t>(first);
        print_share("live spline, samples from " + std::to_string(first) + " on (p50 p99 max)",
                    {from, from + 20 * static_cast<std::ptrdiff_t>(lap)}, target);
    }
    print_share("  all " + std::to_string(us.size()) + " samples", us, "");
    double sum = 0.0;
    const auto asked = time_of(25, [&] {
        for (int k = 0; k < 1000; ++k)
            sum += curve.newest().sigma_mm + curve.predict(0.1).sigma_mm;
    });
    if (sum < 0.0) return;  // keeps the work
    print("  asked for curvature and prediction", {asked.low * 1e3, asked.median * 1e3, asked.high * 1e3}, "us", "");
}

}  // namespace cmm::bench
