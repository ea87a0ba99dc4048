// SPDX-License-Identifier: Apache-2.0
#include "fitting/bspline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace cmm::fitting {
namespace {

using core::ErrorCode;

/// One period of n knots, continued over `degree` spans at either end.
std::vector<double> continued(const std::vector<double>& base, double period, int degree) {
    const auto n = base.size(), p = static_cast<std::size_t>(degree);
    std::vector<double> knots(n + 2 * p + 1);
    for (std::size_t j = 0; j < knots.size(); ++j)
        knots[j] = j < p ? base[n + j - p] - period : j < n + p ? base[j - p] : base[j - p - n] + period;
    return knots;
}

core::Status check(int degree, std::span<const double> knots, std::size_t controls, bool closed) {
    const auto refuse = [](const std::string& why) {
        return core::fail(ErrorCode::fit_not_evaluable, "B-spline: " + why);
    };
    if (degree < 1 || degree > max_degree) return refuse("degree " + std::to_string(degree));
    const auto p = static_cast<std::size_t>(degree);
    if (controls < p + 1) return refuse("needs " + std::to_string(p + 1) + " controls");
    if (knots.size() != controls + p + 1 + (closed ? p : 0)) return refuse("knots and controls do not belong together");
    for (std::size_t i = 0; i < knots.size(); ++i)
        if (!std::isfinite(knots[i]) || (i > 0 && knots[i] < knots[i - 1]))
            return refuse("knot " + std::to_string(i) + " does not ascend");
    const double period = knots[knots.size() - 1 - p] - knots[p];
    if (!(period > 0.0)) return refuse("the domain is empty");
    if (closed)
        for (std::size_t i = 0; i <= 2 * p; ++i)
            if (std::abs(knots[i + controls] - knots[i] - period) > 1e-12 * period)
                return refuse("knot " + std::to_string(i) + " does not repeat after the period");
    return {};
}

}  // namespace

template <int Dim>
core::Result<BSpline<Dim>> BSpline<Dim>::make(int degree, std::vector<double> knots, std::vector<Point> controls,
                                              bool closed) {
    if (auto status = check(degree, knots, controls.size(), closed); !status) return tl::unexpected(status.error());
    for (std::size_t i = 0; i < controls.size(); ++i)
        if (!controls[i].allFinite())
            return core::fail(ErrorCode::fit_not_evaluable,
                              "B-spline: control " + std::to_string(i) + " is not finite");
    return BSpline(degree, std::move(knots), std::move(controls), closed);
}

template <int Dim>
double BSpline<Dim>::inside(double t) const {
    if (!closed_) return std::clamp(t, front(), back());
    if (t >= front() && t < back()) return t;
    const double wrapped = t - std::floor((t - front()) / (back() - front())) * (back() - front());
    return wrapped >= front() && wrapped < back() ? wrapped : front();
}

template <int Dim>
typename BSpline<Dim>::Point BSpline<Dim>::position(double t) const {
    t = inside(t);
    const auto p = static_cast<std::size_t>(degree_);
    const std::size_t k = knot_span(knots_, degree_, t);
    std::array<Point, max_degree + 1> d;
    for (std::size_t j = 0; j <= p; ++j)
        d[j] = control(k - p + j);
    for (std::size_t r = 1; r <= p; ++r)
        for (std::size_t j = p; j >= r; --j) {
            const double low = knots_[k - p + j], share = (t - low) / (knots_[k + 1 + j - r] - low);
            d[j] = (1.0 - share) * d[j - 1] + share * d[j];
        }
    return d[p];
}

template <int Dim>
std::array<typename BSpline<Dim>::Point, 4> BSpline<Dim>::derivatives(double t, int order) const {
    const BasisValues basis = basis_functions(knots_, degree_, inside(t), order);
    std::array<Point, 4> out;
    for (std::size_t m = 0; m < out.size(); ++m) {
        out[m].setZero();
        for (std::size_t a = 0; a <= static_cast<std::size_t>(degree_); ++a)
            out[m] += basis.of[m][a] * control(basis.first + a);
    }
    return out;
}

/// Q_i = a_i P_i + (1 - a_i) P_{i-1}, a_i = (t - u_i) / (u_{i+p} - u_i) for i = k - p + 1 ... k; the others move up.
template <int Dim>
BSpline<Dim> BSpline<Dim>::inserted(std::size_t span, double t) const {
    const auto p = static_cast<std::size_t>(degree_);
    const std::size_t n = controls_.size(), first = closed_ ? span - p + 1 : 0;
    std::vector<Point> controls(n + 1);
    for (std::size_t i = first; i <= first + n; ++i) {
        Point& q = controls[closed_ ? i % (n + 1) : i];
        if (i + p <= span) {
            q = control(i);
        } else if (i > span || (!closed_ && i == n)) {  // the last: N_n begins at t
            q = control(i - 1);
        } else {
            const double share = (t - knots_[i]) / (knots_[i + p] - knots_[i]);
            q = share * control(i) + (1.0 - share) * control(i - 1);
        }
    }
    const auto at = static_cast<std::ptrdiff_t>(span + 1);
    if (!closed_) {
        std::vector<double> knots = knots_;
        knots.insert(knots.begin() + at, t);
        return BSpline(degree_, std::move(knots), std::move(controls), false);
    }
    const auto start = knots_.begin() + degree_;
    std::vector<double> base(start, start + static_cast<std::ptrdiff_t>(n));
    base.insert(base.begin() + (at - degree_), t);
    return BSpline(degree_, continued(base, back() - front(), degree_), std::move(controls), true);
}

template <int Dim>
core::Result<BSpline<Dim>> BSpline<Dim>::with_knot(double t) const {
    if (!(t >= front() && (closed_ ? t < back() : t <= back())))
        return core::fail(ErrorCode::fit_not_evaluable, "B-spline: the new knot lies outside the domain");
    if (std::count(knots_.begin(), knots_.end(), t) >= degree_)
        return core::fail(ErrorCode::fit_not_evaluable, "B-spline: the knot is there already as often as the degree");
    return inserted(static_cast<std::size_t>(std::upper_bound(knots_.begin(), knots_.end(), t) - knots_.begin()) - 1,
                    t);
}

template <int Dim>
std::size_t BSpline<Dim>::last_of(std::size_t r) const {
    while (r + 1 < knots_.size() && !(knots_[r] < knots_[r + 1]))
        ++r;
    return r;
}

template <int Dim>
bool BSpline<Dim>::removable(std::size_t r) const {
    return r < knots_.size() && knots_[r] > front() && knots_[r] < back() &&
           controls_.size() > static_cast<std::size_t>(degree_) + 1;
}

/// Of the p - s + 1 equations of `inserted` (s: multiplicity) for the p - s controls R between, the first are solved
/// from the left, the last from the right. The one in the middle misses by `error`; the curve then changes by
/// error N_misfit(t).
template <int Dim>
typename BSpline<Dim>::Local BSpline<Dim>::local_removal(std::size_t r) const {
    const auto p = static_cast<std::size_t>(degree_), n = controls_.size();
    const double u = knots_[r];
    const auto s = std::min(p, static_cast<std::size_t>(std::count(knots_.begin(), knots_.end(), u)));
    const std::size_t shift = closed_ ? n : 0;  // keeps indices positive
    const auto share = [&](std::size_t i) { return (u - knots_[i]) / (knots_[i + p + 1] - knots_[i]); };
    Local local;
    local.count = p - s;
    const std::size_t from_left = local.count / 2;
    Point left = control(r + shift - p - 1), right = control(r + shift - s + 1);
    for (std::size_t j = 0; j < from_left; ++j) {
        const double a = share(r - p + j);
        left = local.changed[j] = (control(r - p + j) - (1.0 - a) * left) / a;
    }
    for (std::size_t j = local.count; j > from_left; --j) {
        const double a = share(r - p + j);
        right = local.changed[j - 1] = (control(r - p + j) - a * right) / (1.0 - a);
    }
    local.misfit = r - p + from_left;
    const double a = share(local.misfit);
    local.error = (control(local.misfit) - (a * right + (1.0 - a) * left)).norm();
    return local;
}

template <int Dim>
BSpline<Dim> BSpline<Dim>::removed(std::size_t r, const Local& local) const {
    const auto p = static_cast<std::size_t>(degree_), n = controls_.size();
    const std::size_t first = closed_ ? r - p : 0;
    std::vector<Point> controls(n - 1);
    for (std::size_t i = first; i < first + n - 1; ++i)
        controls[closed_ ? i % (n - 1) : i] = i + p < r                 ? control(i)
                                              : i + p < r + local.count ? local.changed[i + p - r]
                                                                        : control(i + 1);
    const auto at = static_cast<std::ptrdiff_t>(r);
    if (!closed_) {
        std::vector<double> knots = knots_;
        knots.erase(knots.begin() + at);
        return BSpline(degree_, std::move(knots), std::move(controls), false);
    }
    const auto start = knots_.begin() + degree_;
    std::vector<double> base(start, start + static_cast<std::ptrdiff_t>(n));
    base.erase(base.begin() + (at - degree_));
    return BSpline(degree_, continued(base, back() - front(), degree_), std::move(controls), true);
}

template <int Dim>
core::Result<typename BSpline<Dim>::Removal> BSpline<Dim>::without_knot(std::size_t r) const {
    if (!removable(r))
        return core::fail(ErrorCode::fit_not_evaluable, "B-spline: knot " + std::to_string(r) + " cannot be removed");
    r = last_of(r);
    const Local local = local_removal(r);
    return Removal{removed(r, local), local.error};
}

template <int Dim>
typename BSpline<Dim>::Removal BSpline<Dim>::reduced(double tolerance) const {
    const auto p = static_cast<std::size_t>(degree_);
    BSpline curve = *this;
    std::vector<double> errors(knots_.size() - 1 - 2 * p, 0.0);  // of the span that begins at knot p + j
    // Spans on which N_misfit lives.
    const auto for_support = [&](const BSpline& of, std::size_t misfit, const auto& what) {
        for (std::size_t j = misfit; j <= misfit + p; ++j) {
            const std::size_t at = j + errors.size() - p;
            if (of.closed_)
                what(errors[at % errors.size()]);
            else if (j >= p && j - p < errors.size())
                what(errors[j - p]);
        }
    };
    for (;;) {
        std::size_t best = 0;
        Local cheapest;
        cheapest.error = std::numeric_limits<double>::infinity();
        for (std::size_t r = p + 1; r + p + 1 < curve.knots_.size(); ++r) {
            if (!curve.removable(r) || curve.last_of(r) != r) continue;
            const Local local = curve.local_removal(r);
            double before = 0.0;
            for_support(curve, local.misfit, [&](double e) { before = std::max(before, e); });
            if (local.error + before <= tolerance && local.error < cheapest.error) {
                cheapest = local;
                best = r;
            }
        }
        if (best == 0) break;
        for_support(curve, cheapest.misfit, [&](double& e) { e += cheapest.error; });
        errors[best - p - 1] = std::max(errors[best - p - 1], errors[best - p]);
        errors.erase(errors.begin() + static_cast<std::ptrdiff_t>(best - p));
        curve = curve.removed(best, cheapest);
    }
    return {std::move(curve), *std::max_element(errors.begin(), errors.end())};
}

template <int Dim>
BSpline<Dim> BSpline<Dim>::opened() const {
    const auto p = static_cast<std::size_t>(degree_);
    std::vector<Point> unrolled = controls_;
    if (closed_) unrolled.insert(unrolled.end(), controls_.begin(), controls_.begin() + degree_);
    BSpline curve(degree_, knots_, std::move(unrolled), false);
    const double ends[] = {front(), back()};
    for (const double end : ends)
        while (std::count(curve.knots_.begin(), curve.knots_.end(), end) < degree_) {
            const auto above = std::upper_bound(curve.knots_.begin(), curve.knots_.end(), end);
            curve = curve.inserted(static_cast<std::size_t>(above - curve.knots_.begin()) - 1, end);
        }
    const auto inner = std::upper_bound(curve.knots_.begin(), curve.knots_.end(), ends[0]);
    const auto outer = std::lower_bound(curve.knots_.begin(), curve.knots_.end(), ends[1]);
    std::vector<double> knots(p + 1, ends[0]);
    knots.insert(knots.end(), inner, outer);
    knots.insert(knots.end(), p + 1, ends[1]);
    const auto first = curve.controls_.begin() + (inner - curve.knots_.begin()) - 1 - degree_;
    std::vector<Point> controls(first, first + static_cast<std::ptrdiff_t>(knots.size() - p - 1));
    return BSpline(degree_, std::move(knots), std::move(controls), false);
}

template class BSpline<2>;
template class BSpline<3>;

}  // namespace cmm::fitting
