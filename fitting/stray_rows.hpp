// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cmm::fitting {

class ColumnSmoother;
class RowColumns;

/// Where a row lies apart from what all others foretell of it.
struct Stray {
    std::size_t row = 0;
    double u = 0.0, reach_mm = 0.0;  ///< a place of the surface, and how far away the next one is
    double most_mm = 0.0;            ///< farther off the others are not, by their scatter
};

/// Where one row lies apart from what all others say (a dent, or a run of bad points that nothing in its section
/// betrays), the others do not follow it: its place in the column is taken by what they foretell, worst first. The
/// lowest and the highest row stand where much of them lies apart, as beside a fillet: they have neighbours on one side
/// only. `z`: of the rows; `columns`: at the u of `breaks`, which begin and end with the period; `normals`: there;
/// `window`: columns to either side whose scatter is looked at together. The smoother's weight is changed. Fewer than
/// six rows all stand.
std::vector<Stray> set_aside_strays(ColumnSmoother& smoother, std::span<const double> z, const RowColumns& normals,
                                    std::span<const double> breaks, std::size_t window, RowColumns& columns);

}  // namespace cmm::fitting
