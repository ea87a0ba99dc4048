// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

/// Frames at the borders. A position that crosses a layer carries its frame in its type; inside a layer plain
/// Eigen vectors in the frame that the function names. Both frames are right-handed, in millimetres.
namespace cmm::core {

struct MachineFrame {};  ///< the controller's axes, origin at its home position
struct PartFrame {};     ///< the nominal's axes: sections lie in planes z = const, span along +z

template <class Frame>
struct Position {
    Eigen::Vector3d mm = Eigen::Vector3d::Zero();
};

/// A rigid motion that takes positions of `From` to positions of `To`.
template <class To, class From>
class RigidTransform {
  public:
    RigidTransform() = default;
    explicit RigidTransform(const Eigen::Isometry3d& motion) : motion_(motion) {}

    Position<To> operator()(const Position<From>& p) const { return {motion_ * p.mm}; }
    Eigen::Vector3d rotate(const Eigen::Vector3d& direction) const { return motion_.linear() * direction; }
    RigidTransform<From, To> inverse() const { return RigidTransform<From, To>(motion_.inverse()); }
    const Eigen::Isometry3d& motion() const { return motion_; }

  private:
    Eigen::Isometry3d motion_ = Eigen::Isometry3d::Identity();
};

using PartFromMachine = RigidTransform<PartFrame, MachineFrame>;
using MachineFromPart = RigidTransform<MachineFrame, PartFrame>;

}  // namespace cmm::core
