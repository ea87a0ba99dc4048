// SPDX-License-Identifier: Apache-2.0
#include "fitting/knots.hpp"

#include <algorithm>

namespace cmm::fitting {
namespace {

using Row = std::array<double, max_degree + 1>;

/// N_{k-d,d} ... N_{k,d} at t, in row[0] ... row[d], from those of degree d - 1.
void raise(std::span<const double> knots, std::size_t k, int degree, double t, Row& row) {
    const auto d = static_cast<std::size_t>(degree);
    double carried = 0.0;
    for (std::size_t a = 0; a < d; ++a) {
        const double left = knots[k + 1 + a - d], right = knots[k + 1 + a], width = right - left;
        const double share = width > 0.0 ? row[a] / width : 0.0;  // 0/0 = 0
        row[a] = carried + (right - t) * share;
        carried = (t - left) * share;
    }
    row[d] = carried;
}

/// Derivatives of the functions of degree d from the same derivatives, one order lower, of those of degree d - 1.
void differentiate(std::span<const double> knots, std::size_t k, int degree, Row& row) {
    const auto d = static_cast<std::size_t>(degree);
    double carried = 0.0;
    for (std::size_t a = 0; a < d; ++a) {
        const double width = knots[k + 1 + a] - knots[k + 1 + a - d];
        const double share = width > 0.0 ? static_cast<double>(degree) * row[a] / width : 0.0;
        row[a] = carried - share;
        carried = share;
    }
    row[d] = carried;
}

}  // namespace

std::size_t knot_span(std::span<const double> knots, int degree, double t) {
    const auto p = static_cast<std::ptrdiff_t>(degree);
    const auto first = knots.begin() + p, last = knots.end() - 1 - p;
    const double inside = t < *last ? t : *last;
    auto above = std::upper_bound(first, last, inside);
    if (above == last)
        while (above - 1 > first && !(*(above - 1) < *last))
            --above;
    return above == first ? static_cast<std::size_t>(p) : static_cast<std::size_t>(above - knots.begin()) - 1;
}

BasisValues basis_functions(std::span<const double> knots, int degree, double t, int order) {
    const std::size_t k = knot_span(knots, degree, t);
    BasisValues values;
    values.first = k - static_cast<std::size_t>(degree);
    for (int derivative = 0; derivative <= std::min({order, degree, BasisValues::max_order}); ++derivative) {
        Row& row = values.of[static_cast<std::size_t>(derivative)];
        row[0] = 1.0;
        int d = 1;
        for (; d <= degree - derivative; ++d)
            raise(knots, k, d, t, row);
        for (; d <= degree; ++d)
            differentiate(knots, k, d, row);
    }
    return values;
}

}  // namespace cmm::fitting
