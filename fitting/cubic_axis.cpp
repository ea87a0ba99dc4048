// SPDX-License-Identifier: Apache-2.0
#include "fitting/cubic_axis.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/bspline.hpp"

namespace cmm::fitting {

core::Result<CubicAxis> CubicAxis::make(std::vector<double> knots, bool closed) {
    const std::size_t beside = closed ? 7 : 4, controls = knots.size() > beside ? knots.size() - beside : 0;
    const auto curve = BSpline<2>::make(3, std::move(knots), std::vector<Vec2>(controls, Vec2::Zero()), closed);
    if (!curve) return tl::unexpected(curve.error());
    CubicAxis axis;
    axis.knots_ = curve->knots();
    axis.controls_ = controls;
    axis.closed_ = closed;
    for (std::size_t k = 3; k + 4 < axis.knots_.size(); ++k) {
        const double low = axis.knots_[k], high = axis.knots_[k + 1];
        if (low < high) axis.spans_.push_back({low, 1.0 / (high - low), k - 3, cubic_basis(&axis.knots_[k - 2])});
    }
    return axis;
}

core::Result<CubicAxis> CubicAxis::on_breaks(const std::vector<double>& breaks, bool closed) {
    const std::size_t spans = breaks.size() - std::min<std::size_t>(1, breaks.size());
    if (spans < (closed ? 4U : 1U))
        return core::fail(core::ErrorCode::fit_not_evaluable, "surface: too few knots in one direction");
    const double period = breaks.back() - breaks.front();
    std::vector<double> knots(breaks);
    for (std::size_t k = 1; k <= 3; ++k) {
        knots.insert(knots.begin(), closed ? breaks[spans - k] - period : breaks.front());
        knots.push_back(closed ? breaks[k] + period : breaks.back());
    }
    return make(std::move(knots), closed);
}

double CubicAxis::inside(double t) const {
    if (t >= front() && t <= back()) return t;
    if (!closed_ || !std::isfinite(t)) return t > back() ? back() : front();
    const double wrapped = t - std::floor((t - front()) / (back() - front())) * (back() - front());
    return wrapped >= front() && wrapped < back() ? wrapped : front();
}

std::size_t CubicAxis::span_of(double t, std::size_t near) const {
    constexpr std::size_t steps = 4;
    std::size_t k = std::min(near, spans_.size() - 1);
    for (std::size_t step = 0; step < steps; ++step) {
        if (t < spans_[k].low && k > 0)
            --k;
        else if (k + 1 < spans_.size() && t >= spans_[k + 1].low)
            ++k;
        else
            return k;
    }
    const auto above =
        std::upper_bound(spans_.begin() + 1, spans_.end(), t, [](double at, const Span& s) { return at < s.low; });
    return static_cast<std::size_t>(above - spans_.begin()) - 1;
}

CubicAxis::Weights CubicAxis::weights(std::size_t span, double t) const {
    using Stored = Eigen::Map<const Eigen::Array4d>;
    const Span& s = spans_[span];
    const Stored c0(s.basis.power[0].data()), c1(s.basis.power[1].data()), c2(s.basis.power[2].data()),
        c3(s.basis.power[3].data());
    const double w = (t - s.low) * s.inverse_width;
    return {c0 + w * (c1 + w * (c2 + w * c3)), s.inverse_width * (c1 + w * (2.0 * c2 + 3.0 * w * c3)),
            s.inverse_width * s.inverse_width * (2.0 * c2 + 6.0 * w * c3)};
}

double CubicAxis::abscissa(std::size_t control) const {
    return (knots_[control + 1] + knots_[control + 2] + knots_[control + 3]) / 3.0;
}

}  // namespace cmm::fitting
