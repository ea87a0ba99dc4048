// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "fitting/surface.hpp"

/// Splines close to given surfaces.
namespace cmm::fitting {

/// The quasi-interpolant of f on uniform knots, exact for cubics, error O(h^4) (de Boor and Fix 1973): u in
/// [0, span_u), closed or open, v in [0, span_v].
inline Surface spline_of(const std::function<Vec3(double, double)>& f, double span_u, std::size_t count_u, bool closed,
                         double span_v, std::size_t count_v) {
    const double hu = span_u / double(count_u), hv = span_v / double(count_v);
    const auto knots = [](double h, std::size_t count) {
        std::vector<double> t;
        for (int k = -3; k <= int(count) + 3; ++k)
            t.push_back(h * k);
        return t;
    };
    const std::size_t nu = count_u + (closed ? 0 : 3), nv = count_v + 3;
    std::vector<Vec3> controls;
    constexpr double weight[] = {-1.0 / 6, 8.0 / 6, -1.0 / 6};
    for (std::size_t j = 0; j < nv; ++j)
        for (std::size_t i = 0; i < nu; ++i) {
            Vec3 sum = Vec3::Zero();
            for (int b = -1; b <= 1; ++b)
                for (int a = -1; a <= 1; ++a)
                    sum += weight[a + 1] * weight[b + 1] * f(hu * (double(i) - 1 + a), hv * (double(j) - 1 + b));
            controls.push_back(sum);
        }
    return *Surface::make(*CubicAxis::make(knots(hu, count_u), closed), *CubicAxis::make(knots(hv, count_v), false),
                          controls);
}

}  // namespace cmm::fitting
