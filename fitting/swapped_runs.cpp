// SPDX-License-Identifier: Apache-2.0
#include "fitting/swapped_runs.hpp"

#include <array>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr std::ptrdiff_t most_between = 3;
constexpr double borne_out = 3.0;  // standard deviations of a prediction

/// The next bad point behind one to three good ones; none where there is no such thing.
std::ptrdiff_t other_flank(ChainState& chain, std::ptrdiff_t before) {
    std::ptrdiff_t after = before + 1;
    while (after - before <= most_between + 1 && chain.exists(after) && chain.state(after) == PointState::good)
        ++after;
    const std::ptrdiff_t between = after - before - 1;
    const bool bounded = between >= 1 && between <= most_between && chain.exists(after);
    return bounded && chain.state(after) == PointState::bad ? after : ChainState::none;
}

void exchange(ChainState& chain, std::ptrdiff_t before, std::ptrdiff_t after) {
    const auto set = [&](PointState flanks, PointState between) {
        for (std::ptrdiff_t i = before; i <= after; ++i)
            chain.state(i) = i == before || i == after ? flanks : between;
    };
    set(PointState::good, PointState::bad);
    std::array<Verdict, most_between + 2> verdicts;
    bool told = true;
    for (std::ptrdiff_t i = before; i <= after && told; ++i) {
        Verdict& verdict = verdicts[static_cast<std::size_t>(i - before)];
        verdict = chain.judge(i);
        const double off = std::abs(verdict.ratio());
        told = verdict.resolved && !verdict.corner &&
               (chain.state(i) == PointState::good ? off < borne_out : off > ChainState::reject_factor);
    }
    if (!told) return set(PointState::bad, PointState::good);
    for (std::ptrdiff_t i = before; i <= after; ++i)
        chain.note(i, chain.state(i), verdicts[static_cast<std::size_t>(i - before)]);
}

}  // namespace

void exchange_swapped_runs(ChainState& chain) {
    for (std::ptrdiff_t before = 0; before < chain.size(); ++before) {
        if (chain.state(before) != PointState::bad) continue;
        const std::ptrdiff_t after = other_flank(chain, before);
        if (after != ChainState::none && chain.residual(before) * chain.residual(after) > 0.0)
            exchange(chain, before, after);
    }
}

}  // namespace cmm::fitting
