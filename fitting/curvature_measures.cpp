// SPDX-License-Identifier: Apache-2.0
#include "fitting/curvature_measures.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::fitting {
namespace {

/// The share of the weights that lies before u.
double weight_before(double u) {
    const double square = u * u;
    return 0.5 + 15.0 / 16.0 * u * (1.0 - square * (2.0 / 3.0 - square / 5.0));
}

double weight_at(double u) {
    const double inside = 1.0 - u * u;
    return 15.0 / 16.0 * inside * inside;
}

}  // namespace

MeanCurvature::MeanCurvature(const ContourGeometry& contour, double window_mm)
    : contour_(&contour), half_mm_(0.5 * window_mm) {
    const std::size_t n = contour.size();
    arc_mm_.reserve(n + 1);
    turn_.reserve(n + 1);
    double turn = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        arc_mm_.push_back(contour.point(i).arc_length_mm);
        turn_.push_back(turn);
        turn += turn_between(contour.point(i).normal, contour.point(i + 1).normal);
    }
    arc_mm_.push_back(contour.perimeter());
    turn_.push_back(turn);
}

template <typename Visit>
void MeanCurvature::visit(double s_mm, const Visit& visit) const {
    const std::size_t n = contour_->size();
    const double perimeter = contour_->perimeter();
    double start = std::fmod(s_mm - half_mm_, perimeter);
    if (start < 0.0) start += perimeter;
    const auto above = std::upper_bound(arc_mm_.begin() + 1, arc_mm_.end() - 1, start);
    auto i = static_cast<std::size_t>(above - arc_mm_.begin()) - 1;
    double shift = -start - half_mm_;  // from arc length to the way from the middle
    for (double reached = -1.0; reached < 1.0; ++i) {
        if (i == n) {
            i = 0;
            shift += perimeter;
        }
        const double length = arc_mm_[i + 1] - arc_mm_[i];
        const double to = std::min(1.0, (arc_mm_[i + 1] + shift) / half_mm_);
        if (length > 0.0) visit(Stretch{i, reached, to, (turn_[i + 1] - turn_[i]) / length});
        reached = std::max(reached, to);
    }
}

double MeanCurvature::at(double s_mm) const {
    double mean = 0.0;
    visit(s_mm,
          [&](const Stretch& part) { mean += part.curvature * (weight_before(part.to) - weight_before(part.from)); });
    return mean;
}

std::size_t MeanCurvature::stretches(double s_mm) const {
    std::size_t count = 0;
    visit(s_mm, [&](const Stretch&) { ++count; });
    return count;
}

Sensitivity MeanCurvature::slopes(double s_mm) const {
    // With the displacement d the direction turns back by d' and the length grows by (1 + curvature d). The mean is
    // the integral of the weight over the direction, so the first changes it by -d'' under the weights, the second
    // by moving the weights along: what lies between the middle and a place pushes all that lies beyond.
    std::vector<Stretch> parts;
    visit(s_mm, [&](const Stretch& part) { parts.push_back(part); });
    const std::size_t n = contour_->size();
    Sensitivity out;
    for (const Stretch& part : parts) {
        const double share =
            (weight_before(part.to) - weight_before(part.from)) / (arc_mm_[part.point + 1] - arc_mm_[part.point]);
        contour_->add_slope({part.point, 0.0}, share, out);
        contour_->add_slope({(part.point + 1) % n, 0.0}, -share, out);
    }
    // Beyond r: the integral of curvature times the weight's slope, from the end of the window inwards.
    const auto push = [&](const Stretch& part, double beyond) {
        const double way = half_mm_ * (part.to - part.from);
        contour_->add({part.point, 0.5}, part.curvature * beyond * way, out);
    };
    double beyond = 0.0;
    for (auto part = parts.rbegin(); part != parts.rend() && part->to > 0.0; ++part) {
        const double from = std::max(part->from, 0.0);
        const double of_part = part->curvature * (weight_at(part->to) - weight_at(from)) / half_mm_;
        push({part->point, from, part->to, part->curvature}, beyond + 0.5 * of_part);
        beyond += of_part;
    }
    beyond = 0.0;
    for (auto part = parts.begin(); part != parts.end() && part->from < 0.0; ++part) {
        const double to = std::min(part->to, 0.0);
        const double of_part = part->curvature * (weight_at(part->from) - weight_at(to)) / half_mm_;
        push({part->point, part->from, to, part->curvature}, beyond + 0.5 * of_part);
        beyond += of_part;
    }
    return out;
}

}  // namespace cmm::fitting
