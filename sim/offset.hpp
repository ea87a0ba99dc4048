// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "sim/surface.hpp"

namespace cmm::sim {

/// Another surface grown along its normals (shrunk when negative). Millimetres; immutable; any thread.
class OffsetSurface final : public Surface {
  public:
    OffsetSurface(std::shared_ptr<const Surface> base, double offset_mm)
        : base_(std::move(base)), offset_mm_(offset_mm) {}

    Contact nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm) const override {
        Contact contact = base_->nearest(centre_mm, warm);
        contact.distance_mm -= offset_mm_;
        contact.point += offset_mm_ * contact.normal;
        return contact;
    }
    Box box() const override {
        const Box inner = base_->box();
        const Eigen::Vector3d margin = Eigen::Vector3d::Constant(offset_mm_);
        return {inner.low - margin, inner.high + margin};
    }
    const Surface& base() const { return *base_; }
    double offset_mm() const { return offset_mm_; }

  private:
    std::shared_ptr<const Surface> base_;
    double offset_mm_;
};

}  // namespace cmm::sim
