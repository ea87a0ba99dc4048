// SPDX-License-Identifier: Apache-2.0
#include "fitting/common_moves.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

#include "fitting/band_solver.hpp"

namespace cmm::fitting {
namespace {

/// Those with the knots that most have.
std::vector<KnownFit*> with_usual_knots(std::span<KnownFit* const> fits) {
    std::vector<KnownFit*> usual;
    for (const KnownFit* fit : fits) {
        std::vector<KnownFit*> same;
        std::copy_if(fits.begin(), fits.end(), std::back_inserter(same),
                     [fit](const KnownFit* other) { return other->has_knots_of(*fit); });
        if (same.size() > usual.size()) usual = std::move(same);
    }
    return usual;
}

}  // namespace

void move_together(std::span<KnownFit* const> fits, int times, std::size_t fewest) {
    const std::vector<KnownFit*> alike = with_usual_knots(fits);
    if (alike.size() < std::max<std::size_t>(fewest, 1)) return;
    const std::size_t controls = alike.front()->controls();
    // Jumps that all rows have alike are one jump, those that each has for itself as many as there are rows.
    const double share_of_jumps = 1.0 / std::sqrt(static_cast<double>(alike.size()));
    BandSolver<4> normal;
    std::vector<double> displacement;
    for (int time = 0; time < times; ++time) {
        normal.reset(controls, true);
        displacement.assign(controls, 0.0);
        for (const KnownFit* fit : alike)
            fit->add_to_common(normal, displacement, share_of_jumps);
        if (!normal.factor()) return;
        normal.solve(std::span(displacement));
        for (KnownFit* fit : alike)
            if (!fit->move_expected(displacement)) return;
    }
}

}  // namespace cmm::fitting
