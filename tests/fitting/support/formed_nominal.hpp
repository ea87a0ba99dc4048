// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "fitting/best_fit.hpp"
#include "support/families.hpp"

/// Nominals from which a blade that was made differs.
namespace cmm::fitting::formed {

/// The blade itself: displacement and twist are nought.
ClosedCurve itself(const families::Blade& blade);

struct Nominal {
    ClosedCurve curve;
    PlaneMotion min_max;  ///< of the exact outline to it
};
/// The blade's outline, displaced along its normals by five harmonics of its length, root mean square `form_mm`, other
/// ones with each seed. The motion is that of 6 000 places of the outline (that such motions are the best ones
/// best_fit_test.cpp shows by brute force).
Nominal of_other_form(const families::Blade& blade, double form_mm, std::uint64_t seed);

}  // namespace cmm::fitting::formed
