// SPDX-License-Identifier: Apache-2.0
#include "acquisition/worst_place.hpp"

#include <algorithm>

#include "fitting/statistics.hpp"

namespace cmm::acquisition {
namespace {

constexpr double places_of_a_point = 3.0;

double points_used(const SectionResult& section) {
    return static_cast<double>(section.points.size() - section.rejected());
}

}  // namespace

double u95_of_worst(const fitting::ContourPoint& worst, double u95_mm, const SectionResult& section) {
    constexpr double points_of_a_value = 12.0;
    const double k =
        std::max(2.0, fitting::coverage_95_of_largest(std::max(1.0, points_used(section) / points_of_a_value)));
    return 0.5 * k * (u95_mm - worst.offset_error_mm) + worst.offset_error_mm;
}

void UncertainLargest::add(double value, double sigma, double bound) {
    largest_ = std::max(largest_, value);
    at_most_ = std::max(at_most_, value + deviate_ * sigma + bound);
    at_least_ = std::max(at_least_, value - deviate_ * sigma - bound);
}

WorstPlace::WorstPlace(const DecisionRule& rule, const SectionResult& section, std::size_t contour_points)
    : coverage_(section.fit->contour_noise.coverage()),
      found_(fitting::upper_deviate_of_largest(
          rule.risk_of_look(),
          std::max(1.0, places_of_a_point * points_used(section) * static_cast<double>(contour_points) /
                            static_cast<double>(section.fit->contour.size())))) {}

void WorstPlace::add(const fitting::ContourPoint& place, double u95_mm, double size_mm) {
    const double bound = place.offset_error_mm + place.bound_mm;
    found_.add(size_mm, std::max(0.0, u95_mm - bound) / coverage_, bound);
}

}  // namespace cmm::acquisition
