// SPDX-License-Identifier: Apache-2.0
#include "fitting/group_order.hpp"

#include <algorithm>

namespace cmm::fitting {
namespace {

using Eigen::Vector3d;

struct NumberedPlace {
    Vector3d at;
    std::uint32_t number;
};

/// `held`: places of the largest group that is not larger than these, or of one above it.
void halve(std::span<NumberedPlace> places, std::size_t held, std::size_t size) {
    while (held >= places.size() && held > 1)
        held /= size;
    if (places.size() < 2) return;
    const std::size_t first = (places.size() + held - 1) / held / 2 * held;
    Vector3d low = places[0].at, high = low;
    for (const NumberedPlace& place : places) {
        low = low.cwiseMin(place.at);
        high = high.cwiseMax(place.at);
    }
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    std::nth_element(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(first), places.end(),
                     [axis](const NumberedPlace& a, const NumberedPlace& b) { return a.at[axis] < b.at[axis]; });
    halve(places.first(first), held, size);
    halve(places.subspan(first), held, size);
}

}  // namespace

std::vector<std::uint32_t> order_in_groups(std::span<const Vector3d> places, std::size_t size) {
    std::vector<NumberedPlace> numbered;
    numbered.reserve(places.size());
    for (const Vector3d& at : places)
        numbered.push_back({at, static_cast<std::uint32_t>(numbered.size())});
    std::size_t held = 1;
    while (size * held < places.size())
        held *= size;
    halve(numbered, held, size);
    std::vector<std::uint32_t> order;
    order.reserve(places.size());
    for (const NumberedPlace& place : numbered)
        order.push_back(place.number);
    return order;
}

}  // namespace cmm::fitting
