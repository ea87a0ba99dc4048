// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "sim/jet.hpp"

namespace cmm::sim {

/// How the piece differs from its nominal in form: turned about the vertical axis through `centre_mm`, from 0 at
/// `z_low_mm` to `twist_rad` at `z_high_mm` (linear in z, continued beyond), then moved by `shift_mm`. Applied to the
/// geometry before the surface is built, so that distances to the warped part are true distances. A value; any thread.
struct Warp {
    double twist_rad = 0.0;
    double z_low_mm = 0.0;
    double z_high_mm = 1.0;
    Eigen::Vector2d centre_mm = Eigen::Vector2d::Zero();
    Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();

    template <class T>
    std::array<T, 3> operator()(const std::array<T, 3>& p) const {
        using std::cos;
        using std::sin;
        const T angle = (p[2] - T(z_low_mm)) * (twist_rad / (z_high_mm - z_low_mm));
        const T c = cos(angle), s = sin(angle);
        const T x = p[0] - T(centre_mm.x()), y = p[1] - T(centre_mm.y());
        return {c * x - s * y + T(centre_mm.x() + shift_mm.x()), s * x + c * y + T(centre_mm.y() + shift_mm.y()),
                p[2] + T(shift_mm.z())};
    }
    Eigen::Vector3d operator()(const Eigen::Vector3d& p) const {
        const auto moved = (*this)(std::array<double, 3>{p.x(), p.y(), p.z()});
        return {moved[0], moved[1], moved[2]};
    }
};

}  // namespace cmm::sim
