// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "acquisition/decision_rule.hpp"
#include "acquisition/section_result.hpp"

/// The largest of a number that has one value at each place of a contour, and what noise may do to it.
namespace cmm::acquisition {

/// Half the 95 % interval of a deviation that is the largest of a zone: found among as many places as there are
/// independent values of the noise, about one for three points, in each of four zones.
double u95_of_worst(const fitting::ContourPoint& worst, double u95_mm, const SectionResult& section);

/// The largest of several uncertain numbers, and how large the largest of their true values may be and is for certain,
/// each being off by no more than `deviate` of its standard deviations and its bound.
class UncertainLargest {
  public:
    explicit UncertainLargest(double deviate) : deviate_(deviate) {}

    void add(double value, double sigma, double bound);
    double largest() const { return largest_; }
    double at_most() const { return at_most_; }
    double at_least() const { return at_least_; }
    GuardBands guards() const { return {at_most_ - largest_, largest_ - at_least_}; }

  private:
    static constexpr double none_yet = std::numeric_limits<double>::lowest();
    double deviate_, largest_ = none_yet, at_most_ = none_yet, at_least_ = none_yet;
};

/// What lies between the largest value of all places and the largest that they may have, and have for certain.
/// All of them share the risk (Sidak 1967), three times as many as the zone has points: the largest of a smooth random
/// curve is that of fewer independent values, and the rest is for the places beside an edge, where the curvature jumps
/// and the curve is farther off than the noise says (docs/theory.md).
class WorstPlace {
  public:
    /// `contour_points` of the section's contour are looked at.
    WorstPlace(const DecisionRule& rule, const SectionResult& section, std::size_t contour_points);

    /// `size_mm`: the number, which errs as the deviation does; `u95_mm` is that of the deviation.
    void add(const fitting::ContourPoint& place, double u95_mm, double size_mm);
    /// Of the largest of what was added.
    GuardBands guards() const { return found_.guards(); }

  private:
    double coverage_;
    UncertainLargest found_;
};

}  // namespace cmm::acquisition
