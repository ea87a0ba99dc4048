// SPDX-License-Identifier: Apache-2.0
#include "sim/probe.hpp"

#include <algorithm>
#include <cmath>

#include "core/rng.hpp"

namespace cmm::sim {

namespace {

// Points are dealt with in blocks of eight with at most one run of bad ones each, which starts in the first five
// places: so runs never meet and are never longer than three.
constexpr std::uint64_t block_size = 8;
constexpr std::uint64_t start_places = 5;
constexpr double share_of_singles = 0.6, share_of_pairs = 0.25;
constexpr double mean_run = share_of_singles + 2.0 * share_of_pairs + 3.0 * (1.0 - share_of_singles - share_of_pairs);
// A lump of dirt lifts the points of a run about alike.
constexpr double least_of_run = 0.7;

enum class Purpose : std::uint64_t { phase, noise, run, point };

core::Rng stream(const ProbeErrorModel& model, Purpose purpose, std::uint16_t path, std::uint64_t index) {
    return core::Rng::keyed(model.seed, (std::uint64_t{path} << 8U) | static_cast<std::uint64_t>(purpose), index);
}

/// The share of bad points among those like this one, so that the shares of the whole path come out as asked.
double local_share(const ProbeErrorModel& model, double edge_ness) {
    const double edges = model.edge_points_share;
    if (edges <= 0.0 || edges >= 1.0) return model.bad_points_share;
    const double at_edges = std::min(1.0, model.bad_points_share * model.bad_at_edges_share / edges);
    if (edge_ness > 0.5) return at_edges;
    return (model.bad_points_share - at_edges * edges) / (1.0 - edges);
}

double log_uniform(core::Rng& rng, double low, double high) {
    return low * std::pow(high / low, rng.uniform());
}

double signed_size(const ProbeErrorModel& model, core::Rng& rng) {
    const double sign = rng.uniform() < model.outward_share ? 1.0 : -1.0;
    return sign * log_uniform(rng, model.smallest_bad_mm, model.largest_bad_mm);
}

double bad_displacement(const ProbeErrorModel& model, std::uint16_t path, std::uint32_t index, double edge_ness) {
    const double share = local_share(model, edge_ness);
    if (share <= 0.0) return 0.0;
    const std::uint64_t place = index + stream(model, Purpose::phase, path, 0).below(block_size);
    core::Rng run = stream(model, Purpose::run, path, place / block_size);
    core::Rng own = stream(model, Purpose::point, path, index);
    const double most_by_runs = mean_run / static_cast<double>(block_size);
    const bool happens = run.uniform() < share / most_by_runs;
    const std::uint64_t first = run.below(start_places);
    const double kind = run.uniform();
    const std::uint64_t length = kind < share_of_singles ? 1 : kind < share_of_singles + share_of_pairs ? 2 : 3;
    const double size = signed_size(model, run);
    const std::uint64_t at = place % block_size;
    if (happens && at >= first && at < first + length) {
        const double part = length == 1 ? 1.0 : own.uniform(least_of_run, 1.0);
        return std::copysign(std::max(model.smallest_bad_mm, part * std::abs(size)), size);
    }
    // More than one run in every block can hold: the rest is drawn point by point.
    const double rest = (share - most_by_runs) / (1.0 - most_by_runs);
    return own.uniform() < rest ? signed_size(model, own) : 0.0;
}

}  // namespace

ProbeError probe_error(const ProbeErrorModel& model, std::uint16_t path, std::uint32_t index, double edge_ness) {
    core::Rng noise = stream(model, Purpose::noise, path, index);
    return {model.noise_mm * noise.normal(), bad_displacement(model, path, index, edge_ness)};
}

}  // namespace cmm::sim
