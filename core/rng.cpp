// SPDX-License-Identifier: Apache-2.0
#include "core/rng.hpp"

#include <cmath>
#include <numbers>

namespace cmm::core {

Rng Rng::keyed(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) noexcept {
    Rng by_seed(seed);
    Rng by_stream(by_seed.next() ^ (stream * 0xd1342543de82ef95ULL));
    Rng by_index(by_stream.next() ^ (index * 0xaf251af3b0f025b5ULL));
    return Rng(by_index.next());
}

std::uint64_t Rng::next() noexcept {
    state_ += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

double Rng::uniform() noexcept {
    return static_cast<double>(next() >> 11) * 0x1.0p-53;
}

std::uint64_t Rng::below(std::uint64_t bound) noexcept {
    return static_cast<std::uint64_t>(uniform() * static_cast<double>(bound));
}

double Rng::normal() noexcept {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

}  // namespace cmm::core
