// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <rapidcheck.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

/// What the property tests draw from.
namespace cmm::fitting {

/// The same cases in every run, unless RC_PARAMS from outside asks for others. To be called before the first property.
inline int same_cases(int count) {
    return setenv("RC_PARAMS", ("seed=3 max_success=" + std::to_string(count)).c_str(), 0);
}

/// Of the full range from the first case on.
template <class T>
rc::Gen<T> whole(T low, T end) {
    return rc::gen::resize(rc::kNominalSize, rc::gen::inRange<T>(low, end));
}

inline rc::Gen<double> real(double low, double high) {
    return rc::gen::map(whole<std::int64_t>(0, 1'000'000'001),
                        [=](std::int64_t k) { return low + (high - low) * static_cast<double>(k) / 1e9; });
}

inline rc::Gen<Eigen::Vector2d> point(double reach) {
    return rc::gen::map(rc::gen::pair(real(-reach, reach), real(-reach, reach)),
                        [](const std::pair<double, double>& p) { return Eigen::Vector2d(p.first, p.second); });
}

/// Numbers that no instrument delivers.
inline rc::Gen<double> garbage() {
    constexpr double inf = std::numeric_limits<double>::infinity(), huge = std::numeric_limits<double>::max();
    return rc::gen::oneOf(
        real(-50.0, 50.0), real(-50.0, 50.0), real(-50.0, 50.0),
        rc::gen::element(0.0, -0.0, 1.0, 1e-300, 1e-16, 1e16, 1e155, -1e155, huge, -huge, inf, -inf,
                         std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::denorm_min()));
}

/// Sometimes all different, sometimes on a line, on one spot, or with repetitions.
inline std::vector<Eigen::Vector2d> garbage_points(std::size_t most) {
    const auto n = *whole<std::size_t>(0, most + 1);
    const int kind = *whole(0, 6);
    std::vector<Eigen::Vector2d> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double x = kind < 3 ? *real(-50.0, 50.0) : *garbage();
        if (kind == 0 && !points.empty())
            points.push_back(points.back());
        else if (kind == 1)
            points.emplace_back(x, 2.0 * x);
        else if (kind == 2 && i % 3 == 2)
            points.push_back(points[i / 2]);
        else
            points.emplace_back(x, kind < 3 ? *real(-50.0, 50.0) : *garbage());
    }
    return points;
}

}  // namespace cmm::fitting
