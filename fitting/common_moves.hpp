// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "fitting/known_fit.hpp"

namespace cmm::fitting {

/// Moves fits of rows that are known to be alike, so many times, to where the points of all of them have them: what
/// the prior of each keeps it from is no error of chance where all points leave the same. Of fits with other knots than
/// most have nothing is heard, and they stay; so do all where fewer than `fewest` have the same.
void move_together(std::span<KnownFit* const> fits, int times, std::size_t fewest);

}  // namespace cmm::fitting
