// SPDX-License-Identifier: Apache-2.0
#include "acquisition/worst_place.hpp"

#include <algorithm>
#include <cmath>

#include "fitting/statistics.hpp"

namespace cmm::acquisition {
namespace {

constexpr double places_of_a_point = 3.0;
constexpr double worst_shared_values = 4.0;  // among which the worst place is found
constexpr std::array<double, 3> share_of_scatter{0.1, 0.5, 0.9};

double points_used(const SectionResult& section) {
    return static_cast<double>(section.points.size() - section.rejected());
}

double share_of(const SectionResult& section, std::size_t contour_points) {
    return static_cast<double>(contour_points) / static_cast<double>(section.fit->contour.size());
}

}  // namespace

double u95_of_worst(const fitting::ContourPoint& worst, double scatter_u95_mm, const SectionResult& section) {
    constexpr double points_of_a_value = 12.0;
    const double k =
        std::max(2.0, fitting::coverage_95_of_largest(std::max(1.0, points_used(section) / points_of_a_value)));
    const double scatter_mm = 0.5 * k * (scatter_u95_mm - worst.offset_error_mm);
    const double shared_mm = worst.machine.shared_mm();
    const double bound_mm = worst.offset_error_mm + worst.flattened_mm + std::abs(worst.machine.known_mm);
    if (shared_mm == 0.0) return scatter_mm + bound_mm;
    return std::hypot(scatter_mm, fitting::coverage_95_of_largest(worst_shared_values) * shared_mm) + bound_mm;
}

LargestGuard::LargestGuard(double risk, double independent, double independent_shared)
    : both_(fitting::upper_deviate_of_largest(risk, independent)) {
    for (std::size_t k = 0; k < splits; ++k) {
        scatter_[k] = fitting::upper_deviate_of_largest(share_of_scatter[k] * risk, independent);
        shared_[k] = fitting::upper_deviate_of_largest((1.0 - share_of_scatter[k]) * risk, independent_shared);
    }
}

double LargestGuard::operator()(double scatter, double shared) const {
    if (shared == 0.0) return both_ * scatter;
    double least = both_ * std::hypot(scatter, shared);
    for (std::size_t k = 0; k < splits; ++k)
        least = std::min(least, scatter_[k] * scatter + shared_[k] * shared);
    return least;
}

void UncertainLargest::add(double value, double spread, double bound) {
    largest_ = std::max(largest_, value);
    at_most_ = std::max(at_most_, value + spread + bound);
    at_least_ = std::max(at_least_, value - spread - bound);
}

WorstPlace::WorstPlace(const DecisionRule& rule, const SectionResult& section, std::size_t contour_points)
    : coverage_(section.fit->contour_noise.coverage()),
      guard_(rule.risk_of_look(),
             std::max(1.0, places_of_a_point * points_used(section) * static_cast<double>(contour_points) /
                               static_cast<double>(section.fit->contour.size())),
             std::max(least_shared_values, shared_values * share_of(section, contour_points))) {}

void WorstPlace::add(const fitting::ContourPoint& place, double scatter_u95_mm, double size_mm) {
    const double bound = place.offset_error_mm + place.bound_mm;
    const double scatter = std::max(0.0, scatter_u95_mm - bound) / coverage_;
    found_.add(size_mm, guard_(scatter, place.machine.shared_mm()),
               bound + place.flattened_mm + std::abs(place.machine.known_mm));
}

}  // namespace cmm::acquisition
