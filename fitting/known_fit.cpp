// SPDX-License-Identifier: Apache-2.0
#include "fitting/known_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "fitting/joint_knots.hpp"
#include "fitting/lack_of_fit.hpp"

namespace cmm::fitting {
namespace {

constexpr int known_tunings = 3;       // where the roughness or nearly the curve is known
constexpr double known_freedom = 4.0;  // of Student's distribution, where the roughness is known
constexpr double most_shift_sigmas = 4.0;
constexpr double far_known_shift = 0.2;  // of a joint's shift: the step of the curvature times its square
/// A bad point that was not found, alone or in a run of a few, does not count as something to follow; a point as far
/// off as `meant_sigmas` is there because somebody wants it.
constexpr double counted_sigmas = 2.0, meant_sigmas = 10.0;

double from_begin(double t, double begin_t, double period) {
    return t - begin_t - period * std::floor((t - begin_t) / period);
}

std::vector<Vec2> points_of(const SmoothCurve& smooth, std::span<const std::size_t> order, const Vec2& origin) {
    std::vector<Vec2> points;
    points.reserve(order.size());
    std::size_t span = 0;
    for (const std::size_t i : order) {
        double t = smooth.parameter[i];
        span = smooth.curve.span_of(t, span);
        const Jet jet = smooth.curve.jet_in(span, t);
        points.emplace_back(jet.position - origin + smooth.residual[i] * jet.right_normal());
    }
    return points;
}

std::vector<std::size_t> order_from(const SmoothCurve& smooth, double begin_t) {
    const auto t = [&](std::size_t i) { return from_begin(smooth.parameter[i], begin_t, smooth.curve.period()); };
    std::vector<std::size_t> order(smooth.parameter.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return t(a) < t(b); });
    return order;
}

Vec2 origin_of(const SmoothCurve& smooth) {
    const Vec2 start = smooth.curve.pieces().front()[0];
    return {std::round(start.x()), std::round(start.y())};
}

/// Whether joints in order leave each other, and the curve's beginning, their knots.
bool all_have_room(std::span<const CurvatureStep> joints, std::span<const double> breaks) {
    constexpr double far = std::numeric_limits<double>::infinity();
    double before = -far;
    for (const CurvatureStep& joint : joints)
        if (!have_room(std::exchange(before, joint.t), joint.t, breaks)) return false;
    return have_room(before, far, breaks);
}

}  // namespace

KnownFit::KnownFit(const SmoothCurve& smooth, double begin_t)
    : order_(order_from(smooth, begin_t)),
      origin_(origin_of(smooth)),
      system_(points_of(smooth, order_, origin_), smooth.sigma_mm) {
    for (const std::size_t i : order_)
        t_.push_back(from_begin(smooth.parameter[i], begin_t, smooth.curve.period()));
}

core::Status KnownFit::fit(const KnownShape& shape) {
    roughness_known_ = !shape.roughness.empty();
    doubt_ = roughness_known_ ? shape.roughness_doubt : own_roughness_doubt;
    const bool anew = !std::exchange(begun_, true) || joints_.size() != shape.joints.size();
    if (anew) {
        joints_.clear();
        for (const KnownJoint& joint : shape.joints)
            joints_.push_back({on_grid(joint.t), joint.step});
    }
    if (auto status = open(shape, anew); !status) return status;
    if (auto status = refine(shape, roughness_known_ ? known_tunings : free_tunings); !status) return status;
    if (shift(shape)) {
        if (auto status = open(shape, false); !status) return status;
        if (auto status = refine(shape, known_tunings); !status) return status;
    }
    for (std::size_t j = 0; j < joints_.size(); ++j)
        tell_place(system_, knots_[j], shape.joints[j].step, joints_[j], ahead(shape, j));
    system_.measure();
    return {};
}

core::Status KnownFit::open(const KnownShape& shape, bool anew) {
    if (!all_have_room(joints_, shape.breaks))
        return core::fail(core::ErrorCode::fit_not_evaluable,
                          "smoothing spline: a joint of the curvature is too near to another, or to where the curve "
                          "begins");
    std::vector<double> places;
    for (const CurvatureStep& joint : joints_)
        places.push_back(joint.t);
    auto breaks = with_joint_knots(shape.breaks, places, knots_);
    return anew ? system_.start(std::move(breaks), t_) : system_.change_breaks(std::move(breaks), {});
}

core::Status KnownFit::refine(const KnownShape& shape, int count) {
    if (roughness_known_) adopt_roughness(shape);
    for (std::size_t j = 0; j < joints_.size(); ++j)
        free_joint(system_, knots_[j], shape.joints[j].step, shape.joints[j].sigma_mm, ahead(shape, j));
    return system_.refine(count);
}

void KnownFit::adopt_roughness(const KnownShape& shape) {
    std::vector<double> variance(system_.spans());
    for (std::size_t k = 0; k < variance.size(); ++k) {
        const auto at = std::lower_bound(shape.breaks.begin(), shape.breaks.end(), system_.breaks()[k + 1]);
        const auto i = static_cast<std::size_t>(at - shape.breaks.begin()) % shape.roughness.size();
        variance[k] = shape.roughness[i] * system_.mean_length_mm(k);
    }
    system_.roughness().adopt(variance, known_freedom);
}

bool KnownFit::shift(const KnownShape& shape) {
    bool strayed = false;
    std::vector<CurvatureStep> shifted = joints_;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
        const KnownJoint& known = shape.joints[j];
        joints_[j].step = seen_at(system_.curve(), joints_[j].t, knots_[j].apart).step;
        const double most = most_shift_sigmas * known.sigma_mm, off = off_expected_mm(system_, knots_[j], known.step);
        const double place = on_grid(known.t + std::clamp(off, -most, most)), moved = place - joints_[j].t;
        strayed = strayed || std::abs(known.step) * moved * moved > far_known_shift * system_.sigma_mm();
        shifted[j] = {place, joints_[j].step};
    }
    if (strayed) joints_ = std::move(shifted);
    return strayed;
}

bool KnownFit::follows() const {
    const double sigma = system_.sigma_mm();
    std::vector<double> residuals = system_.residuals();
    for (double& r : residuals) {
        if (std::abs(r) > meant_sigmas * sigma) return false;
        r = std::clamp(r, -counted_sigmas * sigma, counted_sigmas * sigma);
    }
    const auto lacking = not_followed(residuals, least_sigma_mm);
    return std::find(lacking.begin(), lacking.end(), 1) == lacking.end();
}

std::vector<KnotRoughness> KnownFit::roughness(const KnownShape& shape) const {
    std::vector<KnotRoughness> told(shape.breaks.size() - 1);
    for (std::size_t k = 0; k < system_.spans(); ++k) {
        const auto at = std::lower_bound(shape.breaks.begin(), shape.breaks.end(), system_.breaks()[k + 1]);
        if (at != shape.breaks.end() && *at == system_.breaks()[k + 1])
            told[static_cast<std::size_t>(at - shape.breaks.begin()) % told.size()] = system_.told_roughness(k);
    }
    return told;
}

bool KnownFit::has_knots_of(const KnownFit& other) const {
    return controls() == other.controls() &&
           std::equal(knots_.begin(), knots_.end(), other.knots_.begin(), other.knots_.end(),
                      [](const KnotCluster& a, const KnotCluster& b) { return a.first == b.first; });
}

core::Status KnownFit::move_expected(std::span<const double> displacement) {
    system_.move_expected(displacement);
    if (auto status = system_.refine(1); !status) return status;
    system_.measure();
    return {};
}

SmoothCurve KnownFit::finish() && {
    return std::move(system_).finish(std::move(joints_), order_, origin_, doubt_);
}

std::vector<double> own_breaks(const SmoothCurve& smooth, double begin_t) {
    std::vector<double> breaks = smooth.curve.breaks();
    for (const CurvatureStep& joint : smooth.joints) {  // of the three breaks of a joint the middle one is left
        const auto above = std::upper_bound(breaks.begin() + 1, breaks.end() - 1, joint.t);
        const auto middle = joint.t - above[-1] < *above - joint.t ? above - 1 : above;
        if (middle - breaks.begin() < 2 || breaks.end() - middle < 3) continue;
        breaks.erase(middle + 1);
        breaks.erase(middle - 1);
    }
    const double period = smooth.curve.period();
    breaks.pop_back();
    for (double& b : breaks)
        b = from_begin(b, begin_t, period);
    std::sort(breaks.begin(), breaks.end());
    // The nearest knot goes to where the curve begins.
    if (period - breaks.back() < breaks.front())
        breaks.pop_back();
    else
        breaks.erase(breaks.begin());
    breaks.insert(breaks.begin(), 0.0);
    breaks.push_back(period);
    return breaks;
}

}  // namespace cmm::fitting
