// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/rng.hpp"
#include "support/families.hpp"

namespace cmm::fitting::families {
namespace {

constexpr std::size_t near_edge = 8;  // points

std::array<std::size_t, 4> counts(const Blade& blade, const ScanOptions& options) {
    std::array<std::size_t, 4> count{};
    std::array<double, 4> length{};
    for (std::size_t part = 0; part < 4; ++part)
        length[part] = blade.length_of(static_cast<Part>(part), options.ball_mm);
    if (options.side_pitch_mm > 0) {
        for (std::size_t part = 0; part < 4; ++part) {
            const double pitch = part % 2 == 0 ? options.edge_pitch_mm : options.side_pitch_mm;
            count[part] = static_cast<std::size_t>(std::max(3.0, std::round(length[part] / pitch)));
        }
        return count;
    }
    const auto edge = static_cast<std::size_t>(std::llround(options.edge_share * static_cast<double>(options.points)));
    const std::size_t sides = options.points - 2 * edge;
    const double share = length[1] / (length[1] + length[3]);
    count = {edge, static_cast<std::size_t>(std::llround(share * static_cast<double>(sides))), edge, 0};
    count[3] = sides - count[1];
    return count;
}

/// Bad points in runs; two runs keep good points between them, or they would be one longer run.
void spoil(const std::vector<char>& at_edge, const ScanOptions& options, core::Rng& rng, std::vector<double>& bad) {
    const std::size_t n = bad.size();
    auto wanted = static_cast<std::size_t>(std::llround(options.bad_share * static_cast<double>(n)));
    const auto magnitude = [&] {
        return options.bad_low_mm * std::pow(options.bad_high_mm / options.bad_low_mm, rng.uniform());
    };
    for (int tries = 0; wanted >= options.shortest_run && wanted > 0 && tries < 100000; ++tries) {
        const bool edge = rng.uniform() < options.bad_at_edges;
        const std::size_t at = rng.below(n);
        const std::size_t run = std::min<std::size_t>(
            wanted, options.shortest_run + rng.below(options.longest_run - options.shortest_run + 1));
        if (edge != (at_edge[at] != 0)) continue;
        bool free = true;
        for (std::size_t k = 0; k < run + 2 * options.least_between; ++k)
            free = free && bad[(at + n + k - options.least_between) % n] == 0;
        if (!free) continue;
        const double size = magnitude(), sign = rng.uniform() < options.outward ? 1 : -1;
        const bool alike = rng.uniform() < 0.5;
        for (std::size_t k = 0; k < run; ++k)
            bad[(at + k) % n] =
                sign * (alike ? std::clamp(size * rng.uniform(0.8, 1.25), options.bad_low_mm, options.bad_high_mm)
                              : magnitude());
        wanted -= run;
    }
}

/// Something lies on the part: a smooth bump under several points.
void soil(const std::vector<double>& bad, const ScanOptions& options, core::Rng& rng, std::vector<double>& dirt) {
    const std::size_t n = dirt.size();
    std::size_t wanted = options.dirt;
    for (int tries = 0; wanted > 0 && tries < 10000; ++tries) {
        const std::size_t at = rng.below(n), width = 5 + rng.below(6);
        const double height = rng.uniform(0.020, 0.060);
        bool free = true;
        for (std::size_t k = 0; k < width + 4; ++k)
            free = free && bad[(at + n + k - 2) % n] == 0 && dirt[(at + n + k - 2) % n] == 0;
        if (!free) continue;
        for (std::size_t k = 0; k < width; ++k)
            dirt[(at + k) % n] = height * std::pow(std::sin(std::numbers::pi * (double(k) + 0.5) / double(width)), 2);
        --wanted;
    }
}

template <class T>
void start_at(std::vector<T>& values, std::size_t first, std::size_t again, bool backwards) {
    std::rotate(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(first), values.end());
    for (std::size_t k = 0; k < again; ++k)
        values.push_back(values[k]);
    if (backwards) std::reverse(values.begin(), values.end());
}

/// Where to measure, and what of it is an edge.
void place_points(const Blade& blade, const ScanOptions& options, core::Rng& rng, BladeScan& result,
                  std::vector<char>& at_edge) {
    if (!options.places.empty()) {
        result.t = options.places;
        for (const double t : result.t)
            at_edge.push_back(Blade::part_of(t) == Part::le || Blade::part_of(t) == Part::te);
        return;
    }
    const auto count = counts(blade, options);
    for (std::size_t part = 0; part < 4; ++part) {
        std::vector<double> shares;
        for (std::size_t k = 0; k < count[part]; ++k)
            shares.push_back((double(k) + 0.5 + options.jitter * rng.uniform(-1, 1)) / double(count[part]));
        for (std::size_t k = 0; k < count[part]; ++k)
            at_edge.push_back(part % 2 == 0 || k < near_edge || k + near_edge >= count[part]);
        for (const double t : blade.even_parameters(static_cast<Part>(part), options.ball_mm, shares))
            result.t.push_back(t);
    }
}

}  // namespace

BladeScan scan(const Blade& blade, const ScanOptions& options) {
    core::Rng rng = core::Rng::keyed(options.seed, 0x5CA9, 0);
    BladeScan result;
    std::vector<char> at_edge;
    place_points(blade, options, rng, result, at_edge);
    const std::size_t n = result.t.size();
    result.bad.assign(n, 0.0);
    result.dirt.assign(n, 0.0);
    spoil(at_edge, options, rng, result.bad);
    soil(result.bad, options, rng, result.dirt);
    const auto again = static_cast<std::size_t>(options.overlap * static_cast<double>(n));
    const std::size_t first = rng.below(n);
    start_at(result.t, first, again, options.clockwise);
    start_at(result.bad, first, again, options.clockwise);
    start_at(result.dirt, first, again, options.clockwise);
    for (std::size_t i = 0; i < result.t.size(); ++i) {
        const OutlineJet jet = blade.at(result.t[i]);
        const double off = options.sigma_mm * rng.normal() + result.bad[i] + result.dirt[i];
        result.points.push_back(jet.position + (options.ball_mm + off) * jet.normal());
    }
    return result;
}

}  // namespace cmm::fitting::families
