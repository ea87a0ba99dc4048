// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace cmm::fitting {

/// B-spline basis on a knot sequence u_0 <= u_1 <= ... of any multiplicity; parameters in [u_p, u_{m-p}].
constexpr int max_degree = 9;

/// Last k with u_k <= t < u_{k+1} inside the domain; the last span is closed (seed 000, eq 7 with the spans half open).
std::size_t knot_span(std::span<const double> knots, int degree, double t);

/// The degree + 1 basis functions that do not vanish on a span and their derivatives:
/// of[d][a] is the d-th derivative of N_{first+a,degree}.
struct BasisValues {
    static constexpr int max_order = 3;
    std::size_t first = 0;
    std::array<std::array<double, max_degree + 1>, max_order + 1> of{};
};

/// By the recursion of seed 000, eq 7 and the differences of Piegl and Tiller 1997, algorithm A2.3;
/// order <= max_order (zero above the degree), degree <= max_degree.
BasisValues basis_functions(std::span<const double> knots, int degree, double t, int order);

}  // namespace cmm::fitting
