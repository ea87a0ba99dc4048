// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "acquisition/decision_rule.hpp"
#include "acquisition/section_result.hpp"

/// The largest of a number that has one value at each place of a contour, and what noise may do to it.
namespace cmm::acquisition {

/// Half the 95 % interval of a deviation that is the largest of a zone: found among as many places as there are
/// independent values of the noise, about one for three points, in each of four zones. `scatter_u95_mm`: of the
/// deviation, without machine, probe and temperature, which come to it here.
double u95_of_worst(const fitting::ContourPoint& worst, double scatter_u95_mm, const SectionResult& section);

/// So many independent values what the machine does has along a whole contour: its largest passes a level as often as
/// that of so many (Rice 1945, twelve values along the contour and lobes up to the fourth).
inline constexpr double shared_values = 16.0;
inline constexpr double least_shared_values = 8.0;  // in a zone: at an edge the normal turns much

/// How much a number that is the largest of many may be off at one place: of `independent` values of the scatter and
/// fewer of what the machine does alike to whole stretches, together at a risk. The smaller of two bounds: of the sum
/// as if it had as many independent values as the scatter (Sidak 1967), and of either by itself, at a share of the
/// risk.
class LargestGuard {
  public:
    LargestGuard(double risk, double independent, double independent_shared);
    double operator()(double scatter, double shared) const;

  private:
    static constexpr std::size_t splits = 3;
    double both_;
    std::array<double, splits> scatter_{}, shared_{};
};

/// The largest of several uncertain numbers, and how large the largest of their true values may be and is for certain,
/// each being off by no more than its spread and its bound.
class UncertainLargest {
  public:
    void add(double value, double spread, double bound);
    double largest() const { return largest_; }
    double at_most() const { return at_most_; }
    double at_least() const { return at_least_; }
    GuardBands guards() const { return {at_most_ - largest_, largest_ - at_least_}; }

  private:
    static constexpr double none_yet = std::numeric_limits<double>::lowest();
    double largest_ = none_yet, at_most_ = none_yet, at_least_ = none_yet;
};

/// What lies between the largest value of all places and the largest that they may have, and have for certain.
/// All of them share the risk (Sidak 1967), three times as many as the zone has points: the largest of a smooth random
/// curve is that of fewer independent values, and the rest is for the places beside an edge, where the curvature jumps
/// and the curve is farther off than the noise says (docs/theory.md).
class WorstPlace {
  public:
    /// `contour_points` of the section's contour are looked at.
    WorstPlace(const DecisionRule& rule, const SectionResult& section, std::size_t contour_points);

    /// `size_mm`: the number, which errs as the deviation does; `scatter_u95_mm` is that of the deviation.
    void add(const fitting::ContourPoint& place, double scatter_u95_mm, double size_mm);
    /// Of the largest of what was added.
    GuardBands guards() const { return found_.guards(); }

  private:
    double coverage_;
    LargestGuard guard_;
    UncertainLargest found_;
};

}  // namespace cmm::acquisition
