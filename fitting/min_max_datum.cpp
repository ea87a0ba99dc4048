// SPDX-License-Identifier: Apache-2.0
#include "fitting/min_max_datum.hpp"

#include "fitting/statistics.hpp"

namespace cmm::fitting {

void widen_for_min_max(Datum& datum) {
    constexpr double independent = 50.0;
    const double factor = coverage_95_of_largest(independent) / coverage_95_of_largest(1.0);
    for (auto& number : datum.slopes) {
        Sensitivity wider;
        wider.add(number, factor);
        number = wider;
    }
    datum.covariance *= factor * factor;
    datum.from_others *= factor * factor;
}

}  // namespace cmm::fitting
