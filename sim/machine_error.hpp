// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace cmm::sim {

/// By what a machine and its probe err alike each time: axes that read too long, axes that are not square, and a probe
/// whose ball is felt too early or too late with the direction from which it touches. Millimetres, machine frame.
struct MachineError {
    Eigen::Vector3d scale = Eigen::Vector3d::Zero();       ///< of x, y, z: a millimetre reads so much longer
    Eigen::Vector3d squareness = Eigen::Vector3d::Zero();  ///< x reads more by this times y; x by z; y by z
    double lobes_mm = 0.0;                                 ///< height of the lobes
    int lobes = 3;                                         ///< round the stylus
    double lobes_from_rad = 0.0;                           ///< where one of them is, from +x

    /// What is added to the true ball centre in contact; `normal`: out of the material.
    Eigen::Vector3d at(const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& normal) const {
        Eigen::Vector3d out = scale.cwiseProduct(centre_mm);
        out.x() += squareness.x() * centre_mm.y() + squareness.y() * centre_mm.z();
        out.y() += squareness.z() * centre_mm.z();
        const double level = std::hypot(normal.x(), normal.y());
        if (lobes_mm == 0.0 || level == 0.0) return out;
        const double direction = std::atan2(normal.y(), normal.x());
        return out + lobes_mm * level * std::cos(lobes * (direction - lobes_from_rad)) * normal;
    }
};

}  // namespace cmm::sim
