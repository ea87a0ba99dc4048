// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>

#include "bench/pictures/pictures.hpp"
#include "fitting/live_spline.hpp"
#include "support/airfoil.hpp"

namespace cmm::pictures {
namespace {

constexpr std::size_t samples = 1'000'000, group = 5'000, lap = 2'000;
constexpr double most_us = 22.0;

/// Each sample of a scan that goes round and round, timed.
std::vector<double> times_us() {
    const fitting::airfoil::Airfoil truth(1.0);
    const auto scan = truth.scan(lap, fitting::airfoil::Airfoil::Spacing::edges, 1e-3, 1);
    fitting::LiveSpline live(fitting::MaterialSide::left);
    std::vector<double> us;
    us.reserve(samples);
    for (std::size_t i = 0; i < samples; ++i) {
        const auto start = std::chrono::steady_clock::now();
        live.add(i, scan[i % lap]);
        us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
    }
    return us;
}

}  // namespace

std::string sample_cost() {
    auto us = times_us();
    std::vector<double> at, median, high;
    for (std::size_t first = 0; first < samples; first += group) {
        const auto from = us.begin() + static_cast<std::ptrdiff_t>(first);
        std::sort(from, from + group);
        at.push_back(static_cast<double>(first + group / 2) / 1e3);
        median.push_back(from[group / 2]);
        high.push_back(from[group * 99 / 100]);
    }
    svg::Picture picture(width_px, 270, "time a sample over a million samples");
    const auto frame = frame_at(26, 200, {0.0, 0.0}, {samples / 1e3, most_us});
    frame.draw_axes(picture, "thousand samples", "\u00b5s a sample", 10, 6);
    picture.line("limit", frame.px({0.0, 2.0}), frame.px({samples / 1e3, 2.0}));
    picture.line("limit", frame.px({0.0, 20.0}), frame.px({samples / 1e3, 20.0}));
    picture.clip(frame.corner(), frame.size());
    picture.path("centre", svg::polyline(graph(frame, at, high), false, 0.2));
    picture.path("measured", svg::polyline(graph(frame, at, median), false, 0.2));
    picture.unclip();
    picture.text("strong", {left_px, 16}, svg::Anchor::start,
                 "median (thick) and 99 % (thin) of every 5 000 samples; dashed: 2 and 20 \u00b5s");
    return picture.finish();
}

}  // namespace cmm::pictures
