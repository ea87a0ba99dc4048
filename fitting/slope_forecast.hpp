// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace cmm::fitting {

/// How well other sections tell a slope over z at a section's height: by how far the polynomial through what they are
/// at their heights misses what the section itself is (docs/theory.md, section 12, "Uncertainty"). Value type.
class SlopeForecast {
  public:
    static constexpr std::size_t most_others = 4;

    /// Of the others, no two alike, `most_others` at most, from the section's own height; mm, none 0.
    explicit SlopeForecast(std::span<const double> heights_mm);

    /// What the polynomial is at the section's height: the others' values so weighted (Lagrange's weights), and summed.
    double weight(std::size_t other) const { return weight_[other]; }

    /// Of the slope, when the polynomial misses by so much. Infinite with fewer than two others.
    double slope_error(double missed_mm) const;

  private:
    std::array<double, most_others> weight_{};
    double step_mm_ = 0.0;  // 0: nothing is told
};

}  // namespace cmm::fitting
