// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <utility>

#include "sim/surface.hpp"

namespace cmm::sim {

/// Another surface as it stands on the fixture: turned about the origin by `turn_rad` (axis times angle), then moved.
/// Millimetres; immutable; any thread.
class PlacedSurface final : public Surface {
  public:
    PlacedSurface(std::shared_ptr<const Surface> part, const Eigen::Vector3d& at_mm, const Eigen::Vector3d& turn_rad)
        : part_(std::move(part)), at_mm_(at_mm) {
        const double angle = turn_rad.norm();
        if (angle > 0.0) turn_ = Eigen::AngleAxisd(angle, turn_rad / angle).toRotationMatrix();
    }

    Contact nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm) const override {
        Contact contact = part_->nearest(turn_.transpose() * (centre_mm - at_mm_), warm);
        contact.point = turn_ * contact.point + at_mm_;
        contact.normal = turn_ * contact.normal;
        return contact;
    }
    Box box() const override {
        const Box inner = part_->box();
        const Eigen::Vector3d middle = turn_ * (0.5 * (inner.low + inner.high)) + at_mm_;
        const Eigen::Vector3d half = turn_.cwiseAbs() * (0.5 * (inner.high - inner.low));
        return {middle - half, middle + half};
    }

  private:
    std::shared_ptr<const Surface> part_;
    Eigen::Vector3d at_mm_;
    Eigen::Matrix3d turn_ = Eigen::Matrix3d::Identity();
};

}  // namespace cmm::sim
