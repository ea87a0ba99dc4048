// SPDX-License-Identifier: Apache-2.0
#include "fitting/contour_noise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "fitting/section.hpp"

namespace cmm::fitting {
namespace {

/// Each point once: bounds add what is left of a point, not what was added and taken away again.
std::vector<std::pair<std::size_t, double>> merged(const Sensitivity& number) {
    auto parts = number.parts();
    std::sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::pair<std::size_t, double>> out;
    for (const auto& [point, weight] : parts) {
        if (!out.empty() && out.back().first == point)
            out.back().second += weight;
        else
            out.emplace_back(point, weight);
    }
    return out;
}

/// Of a random function along the contour, `size_of` its standard deviation at a point: between two of equally spaced
/// values as the cosine and the sine of a quarter turn, so that its variance is the same everywhere.
template <class SizeOf>
PlaceLoads loads_along(std::span<const ContourPoint> contour, const Sensitivity& number, SizeOf&& size_of) {
    PlaceLoads out = PlaceLoads::Zero();
    const double whole = contour.empty() ? 1.0 : std::max(contour.back().arc_length_mm, 1e-12);
    for (const auto& [point, weight] : merged(number)) {
        const ContourPoint& p = contour[point];
        const double place = p.arc_length_mm / whole * static_cast<double>(out.size());
        const double floor = std::floor(place), part = 0.5 * std::numbers::pi * (place - floor);
        const auto k = static_cast<Eigen::Index>(floor);
        out[k % out.size()] += weight * size_of(p) * std::cos(part);
        out[(k + 1) % out.size()] += weight * size_of(p) * std::sin(part);
    }
    return out;
}

}  // namespace

ContourNoise::ContourNoise(CurveNoise free, std::vector<EdgePatch> patches, double period, double coverage)
    : free_(std::move(free)), patches_(std::move(patches)), period_(period), coverage_(coverage) {}

ContourNoise::PlaceDependence ContourNoise::dependence_of(const ContourPoint& point) const {
    for (std::size_t k = 0; k < patches_.size(); ++k) {
        auto on = patches_[k].dependence(point.t, period_, from_contour_.apply(point.position_mm),
                                         from_contour_.apply_to_direction(point.normal));
        if (on) return {on->on_free, k, std::move(on->on_model)};
    }
    return {};
}

double ContourNoise::variance(std::span<const ContourPoint> contour, const Sensitivity& number) const {
    if (!free_) {
        double sum = 0.0;
        for (const auto& [point, weight] : merged(number))
            sum += std::abs(weight) * contour[point].u95_mm / coverage_;
        return sum * sum;
    }
    std::vector<double> scattered(free_->controls(), 0.0), kept(free_->controls(), 0.0);
    CurveNoise::Walk places(*free_);
    std::vector<Eigen::VectorXd> by_model(patches_.size());
    for (std::size_t k = 0; k < patches_.size(); ++k)
        by_model[k] = Eigen::VectorXd::Zero(patches_[k].covariance.rows());
    for (const auto& [point, weight] : merged(number)) {
        const ContourPoint& p = contour[point];
        const PlaceDependence on = dependence_of(p);
        if (on.on_model.size() > 0) by_model[on.patch] += weight * on.on_model;
        if (on.on_free > 0.0) {
            places.add_place(p.t, weight * p.scatter_share * on.on_free, scattered);
            places.add_place(p.t, weight * p.kept_share * on.on_free, kept);
        }
    }
    double variance = free_->variance(scattered).scatter + free_->variance(kept).kept;
    for (std::size_t k = 0; k < patches_.size(); ++k)
        variance += std::max(0.0, by_model[k].dot(patches_[k].covariance * by_model[k]));
    return variance;
}

Eigen::MatrixXd ContourNoise::covariance(std::span<const ContourPoint> contour,
                                         std::span<const std::size_t> places) const {
    const auto m = static_cast<Eigen::Index>(places.size());
    if (!free_) {
        Eigen::VectorXd alike(m);
        for (Eigen::Index k = 0; k < m; ++k)
            alike[k] = contour[places[static_cast<std::size_t>(k)]].u95_mm / coverage_;
        return alike * alike.transpose();
    }
    std::vector<PlaceDependence> on;
    std::vector<std::vector<std::pair<std::size_t, double>>> by_control;
    std::vector<std::vector<double>> with_controls;
    CurveNoise::Walk walk(*free_);
    for (const std::size_t place : places) {
        const ContourPoint& p = contour[place];
        on.push_back(dependence_of(p));
        std::vector<double> slopes(free_->controls(), 0.0);
        if (on.back().on_free > 0.0) walk.add_place(p.t, p.noise_share * on.back().on_free, slopes);
        auto& parts = by_control.emplace_back();
        for (std::size_t k = 0; k < slopes.size(); ++k)
            if (slopes[k] != 0.0) parts.emplace_back(k, slopes[k]);
        if (!parts.empty()) free_->covary(slopes);
        with_controls.push_back(std::move(slopes));
    }
    Eigen::MatrixXd out(m, m);
    for (Eigen::Index i = 0; i < m; ++i) {
        const auto& of_i = on[static_cast<std::size_t>(i)];
        for (Eigen::Index k = 0; k <= i; ++k) {
            const auto& of_k = on[static_cast<std::size_t>(k)];
            double sum = 0.0;
            for (const auto& [control, slope] : by_control[static_cast<std::size_t>(i)])
                sum += slope * with_controls[static_cast<std::size_t>(k)][control];
            if (of_i.on_model.size() > 0 && of_k.on_model.size() > 0 && of_i.patch == of_k.patch)
                sum += of_i.on_model.dot(patches_[of_i.patch].covariance * of_k.on_model);
            out(i, k) = out(k, i) = sum;
        }
    }
    return out;
}

FieldLoads ContourNoise::loads_at(const ContourPoint& point) const {
    return fields_.at(from_contour_.apply(point.position_mm), from_contour_.apply_to_direction(point.normal),
                      point.rise);
}

double ContourNoise::place_mm(const ContourPoint& point) const {
    return fields_.place_mm(point.rise);
}

FieldLoads ContourNoise::loads(std::span<const ContourPoint> contour, const Sensitivity& number) const {
    FieldLoads out = FieldLoads::Zero();
    if (!fields_.any()) return out;
    for (const auto& [point, weight] : merged(number))
        out += weight * loads_at(contour[point]);
    return out;
}

PlaceLoads ContourNoise::place_loads(std::span<const ContourPoint> contour, const Sensitivity& number) const {
    if (!fields_.any()) return PlaceLoads::Zero();
    return loads_along(contour, number, [this](const ContourPoint& p) { return place_mm(p); });
}

/// The doubt has the sign by which the others missed the section there. What they miss alike all round adds up, what is
/// chance goes together from place to place only: which it is nobody knows, and both count.
double ContourNoise::drawn_variance(std::span<const ContourPoint> contour, const Sensitivity& number) const {
    double together = 0.0;
    for (const auto& [point, weight] : number.parts())
        together += weight * contour[point].drawn_mm;
    const auto apart = loads_along(contour, number, [](const ContourPoint& p) { return p.drawn_mm; });
    return (together * together + apart.squaredNorm()) / (coverage_ * coverage_);
}

NumberUncertainty ContourNoise::of(std::span<const ContourPoint> contour, const Sensitivity& number,
                                   const BesideContour& beside) const {
    double bound = 0.0, offset = 0.0, weighed = 0.0, in_gaps = 0.0;
    Sensitivity all = number;
    all.add(beside.slopes, 1.0);
    for (const auto& [point, weight] : merged(all)) {
        bound += std::abs(weight) * (contour[point].bound_mm - std::abs(contour[point].drawn_mm));
        offset += weight * contour[point].offset_error_mm;
    }
    for (const auto& [point, weight] : merged(number)) {
        weighed += std::abs(weight);
        if (!contour[point].measured) in_gaps += std::abs(weight);
    }
    NumberUncertainty out;
    const double noise = coverage_ * std::sqrt(variance(contour, number) + drawn_variance(contour, all) +
                                               beside.variance + plane_.variance(number));
    out.in_gaps = weighed > 0.0 ? in_gaps / weighed : 0.0;
    out.offset_error = std::abs(offset);
    out.u95 = noise + bound + out.offset_error;
    out.standard = out.scatter = out.u95 / coverage_;
    out.budget.noise = noise / coverage_;
    out.budget.bound = bound + out.offset_error;
    if (!fields_.any()) return out;
    add_fields(contour, all, beside.loads, out);
    return out;
}

void ContourNoise::add_fields(std::span<const ContourPoint> contour, const Sensitivity& number,
                              const FieldLoads& of_others, NumberUncertainty& out) const {
    out.loads = loads(contour, number) + of_others;
    out.place = place_loads(contour, number).norm();
    for (std::size_t k = 0; k < error_sources; ++k)
        out.budget.machine[k] = std::sqrt(variance_of(out.loads, static_cast<ErrorSource>(k)));
    out.budget.of(ErrorSource::length) = std::hypot(out.budget.of(ErrorSource::length), out.place);
    out.budget.bound += std::abs(known_of(out.loads));
    out.u95 = coverage_ * std::hypot(out.budget.noise, out.budget.shared()) + out.budget.bound;
    out.standard = out.u95 / coverage_;
}

}  // namespace cmm::fitting
