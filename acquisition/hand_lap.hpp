// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

namespace cmm::acquisition {

/// Tells when a person who takes points round a section has passed the point where the section began: the way has
/// turned by most of a full turn, either way round, and crosses the line through the first point in the direction it
/// had there. For a few points as well as for a stream of them. One owner, millimetres.
class HandLap {
  public:
    void add(const Eigen::Vector2d& centre);
    bool closed() const { return closed_; }

  private:
    /// Along the direction of the start; negative: behind it.
    double ahead_of_start(const Eigen::Vector2d& centre) const;
    void turn_to(const Eigen::Vector2d& centre);

    std::optional<Eigen::Vector2d> start_, start_direction_, corner_, direction_;
    Eigen::Vector2d last_ = Eigen::Vector2d::Zero();
    double turned_rad_ = 0.0;
    bool closed_ = false;
};

}  // namespace cmm::acquisition
