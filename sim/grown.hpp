// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "sim/surface.hpp"

namespace cmm::sim {

/// Another surface that is larger in all directions, as warmth makes it: every point at `factor` times its distance
/// from the origin. Millimetres; immutable; any thread.
class GrownSurface final : public Surface {
  public:
    GrownSurface(std::shared_ptr<const Surface> part, double factor) : part_(std::move(part)), factor_(factor) {}

    Contact nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm) const override {
        Contact contact = part_->nearest(centre_mm / factor_, warm);
        contact.distance_mm *= factor_;
        contact.point *= factor_;
        return contact;
    }
    Box box() const override {
        const Box inner = part_->box();
        return {factor_ * inner.low, factor_ * inner.high};
    }

  private:
    std::shared_ptr<const Surface> part_;
    double factor_;
};

}  // namespace cmm::sim
