// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace cmm::fitting {

/// How a number answers, in first order, to small displacements of contour points outwards along their normals: points
/// by index, mm of the number (or rad, or mm^2) per mm. A point may occur more than once. Value type.
class Sensitivity {
  public:
    void add(std::size_t point, double weight) { parts_.emplace_back(point, weight); }
    void add(const Sensitivity& other, double factor) {
        for (const auto& [point, weight] : other.parts_)
            parts_.emplace_back(point, factor * weight);
    }
    const std::vector<std::pair<std::size_t, double>>& parts() const { return parts_; }

  private:
    std::vector<std::pair<std::size_t, double>> parts_;
};

}  // namespace cmm::fitting
