// SPDX-License-Identifier: Apache-2.0
#include "fitting/filter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "core/text.hpp"
#include "fitting/band_solver.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr std::size_t least_samples = 5;
constexpr std::array<std::pair<FilterKind, std::string_view>, 4> kinds{
    {{FilterKind::none, "none"},
     {FilterKind::gaussian, "gaussian"},
     {FilterKind::spline, "spline"},
     {FilterKind::robust_gaussian, "robust_gaussian"}}};

/// Widths of the weight exp(-pi (x / (width cut-off))^2) for which half of the cut-off wavelength passes: sqrt(ln 2/pi)
/// for orders 0 and 1; for orders 2 and 3 the root of (1 + u) exp(-u) = 1/2, u = pi width^2 (ISO 16610-31: 0.7309).
constexpr double first_order_width = 0.46971863934982566;
constexpr double second_order_width = 0.7309134280946759;
constexpr double farthest_widths = 2.2;  // the weight is 2.5e-7 there

/// A profile with the share of the length that each sample stands for.
struct Profile {
    std::span<const double> s, values;
    double period = 0.0;  // 0: open
    std::vector<double> share;

    Profile(std::span<const double> s_mm, std::span<const double> profile_values, double closed_length)
        : s(s_mm), values(profile_values), period(closed_length), share(s_mm.size()) {
        const std::size_t n = s.size();
        for (std::size_t i = 0; i < n; ++i) {
            const bool first = i == 0, last = i + 1 == n;
            const double behind = first ? (closed() ? s[0] + period - s[n - 1] : 0.0) : s[i] - s[i - 1];
            const double ahead = last ? (closed() ? s[0] + period - s[n - 1] : 0.0) : s[i + 1] - s[i];
            share[i] = 0.5 * (behind + ahead);
        }
    }
    bool closed() const { return period > 0.0; }
    std::size_t size() const { return s.size(); }
};

/// The value at each sample of the polynomial that is fitted with Gaussian weights around it, times `trust`.
template <int Order>
std::vector<double> local_regression(const Profile& profile, double width, std::span<const double> trust) {
    using Moments = Eigen::Matrix<double, Order + 1, Order + 1>;
    using Sums = Eigen::Matrix<double, Order + 1, 1>;
    const auto n = static_cast<std::ptrdiff_t>(profile.size());
    const double reach = farthest_widths * width;
    std::vector<double> out(profile.size());
    const auto place = [&](std::ptrdiff_t k) {  // any lap
        const std::ptrdiff_t lap = k >= 0 ? k / n : -((n - 1 - k) / n);
        return profile.s[static_cast<std::size_t>(k - lap * n)] + profile.period * static_cast<double>(lap);
    };
    std::ptrdiff_t first = profile.closed() ? -n : 0, end = first;
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        const double here = profile.s[static_cast<std::size_t>(i)];
        while (place(first) < here - reach)
            ++first;
        end = std::max(end, first);
        while ((profile.closed() || end < n) && place(end) <= here + reach)
            ++end;
        Moments moments = Moments::Zero();
        Sums sums = Sums::Zero();
        for (std::ptrdiff_t k = first; k < end; ++k) {
            const auto at = static_cast<std::size_t>(((k % n) + n) % n);
            const double u = (place(k) - here) / width;
            const double weight = std::exp(-std::numbers::pi * u * u) * profile.share[at] * trust[at];
            Sums powers;
            powers[0] = 1.0;
            for (int p = 1; p <= Order; ++p)
                powers[p] = powers[p - 1] * u;
            moments.noalias() += weight * powers * powers.transpose();
            sums += weight * profile.values[at] * powers;
        }
        const Eigen::LDLT<Moments> factor(moments);
        const bool regular = factor.vectorD().minCoeff() > 1e-10 * moments(0, 0);
        out[static_cast<std::size_t>(i)] = regular               ? Sums(factor.solve(sums))[0]
                                           : moments(0, 0) > 0.0 ? sums[0] / moments(0, 0)
                                                                 : profile.values[static_cast<std::size_t>(i)];
    }
    return out;
}

std::vector<double> robust_regression(const Profile& profile, double width) {
    constexpr int most_rounds = 30;
    constexpr double biweight_medians = 4.4478;  // 3 standard deviations of normal residuals
    std::vector<double> trust(profile.size(), 1.0), residual(profile.size());
    std::vector<double> out = local_regression<2>(profile, width, trust);
    double last_limit = 0.0;
    for (int round = 0; round < most_rounds; ++round) {
        for (std::size_t i = 0; i < residual.size(); ++i)
            residual[i] = std::abs(profile.values[i] - out[i]);
        auto sorted = residual;
        const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
        std::nth_element(sorted.begin(), middle, sorted.end());
        const double limit = biweight_medians * *middle;
        if (!(limit > 0.0) || std::abs(limit - last_limit) <= 1e-3 * limit) break;
        last_limit = limit;
        for (std::size_t i = 0; i < residual.size(); ++i) {
            const double u = residual[i] / limit;
            trust[i] = u < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
        }
        out = local_regression<2>(profile, width, trust);
    }
    return out;
}

/// The cubic spline w that minimises sum of share (value - w)^2 + mu integral of w''^2 (Reinsch 1967), natural at the
/// ends or periodic: it passes 1/(1 + mu (2 pi/lambda)^4) of a wave.
std::vector<double> smoothing_spline(const Profile& profile, double cutoff) {
    const std::size_t n = profile.size(), first = profile.closed() ? 0 : 1, unknowns = n - 2 * first;
    const double mu = std::pow(cutoff / (2.0 * std::numbers::pi), 4);
    const auto at = [&](std::size_t i) { return i % n; };
    const auto step = [&](std::size_t i) {  // from sample i to the next
        return i % n + 1 < n ? profile.s[i % n + 1] - profile.s[i % n]
                             : profile.s[0] + profile.period - profile.s[n - 1];
    };
    // Second differences over steps: row k belongs to samples k - 1, k, k + 1.
    struct Difference {
        std::array<double, 3> of;
    };
    std::vector<Difference> differences(unknowns);
    std::vector<double> bend(unknowns);
    BandSolver<2> solver(unknowns, profile.closed());
    for (std::size_t k = 0; k < unknowns; ++k) {
        const std::size_t i = k + first;
        const double before = step(i + n - 1), after = step(i);
        differences[k] = {{1.0 / before, -1.0 / before - 1.0 / after, 1.0 / after}};
        const auto& d = differences[k].of;
        bend[k] =
            d[0] * profile.values[at(i + n - 1)] + d[1] * profile.values[at(i)] + d[2] * profile.values[at(i + 1)];
    }
    for (std::size_t k = 0; k < unknowns; ++k) {
        const std::size_t i = k + first;
        const auto share = [&](std::size_t j) { return profile.share[at(j)]; };
        const auto& d = differences[k].of;
        double same = (step(i + n - 1) + step(i)) / 3.0;
        for (std::size_t j = 0; j < 3; ++j)
            same += mu * d[j] * d[j] / share(i + n - 1 + j);
        solver.add(k, k, same);
        if (profile.closed() || k + 1 < unknowns) {
            const auto& e = differences[(k + 1) % unknowns].of;
            solver.add(k, (k + 1) % unknowns,
                       step(i) / 6.0 + mu * (d[1] * e[0] / share(i) + d[2] * e[1] / share(i + 1)));
        }
        if (profile.closed() || k + 2 < unknowns)
            solver.add(k, (k + 2) % unknowns, mu * d[2] * differences[(k + 2) % unknowns].of[0] / share(i + 1));
    }
    std::vector<double> out(profile.values.begin(), profile.values.end());
    if (!solver.factor()) return out;
    solver.solve(std::span(bend));
    for (std::size_t k = 0; k < unknowns; ++k)
        for (std::size_t j = 0; j < 3; ++j) {
            const std::size_t i = at(k + first + n - 1 + j);
            out[i] -= mu * differences[k].of[j] * bend[k] / profile.share[i];
        }
    return out;
}

}  // namespace

std::string_view to_string(FilterKind kind) noexcept {
    for (const auto& [value, name] : kinds)
        if (value == kind) return name;
    return "";
}

std::optional<FilterKind> filter_kind_from(std::string_view name) noexcept {
    for (const auto& [value, known] : kinds)
        if (known == name) return value;
    return {};
}

core::Result<std::vector<double>> filter_profile(std::span<const double> s_mm, std::span<const double> values,
                                                 const FilterSpec& spec, double closed_length_mm) {
    const auto refuse = [](const std::string& why) {
        return core::fail(ErrorCode::fit_not_evaluable, "filter: " + why);
    };
    if (s_mm.size() != values.size()) return refuse("not one value for each place");
    if (spec.kind == FilterKind::none) return std::vector<double>(values.begin(), values.end());
    if (s_mm.size() < least_samples) return refuse("fewer than " + std::to_string(least_samples) + " samples");
    for (std::size_t i = 0; i < s_mm.size(); ++i)
        if (!std::isfinite(s_mm[i]) || !std::isfinite(values[i]) || (i > 0 && !(s_mm[i] > s_mm[i - 1])))
            return refuse("places must ascend and all numbers be finite");
    const double length = s_mm.back() - s_mm.front();
    if (closed_length_mm != 0.0 && !(closed_length_mm > length)) return refuse("the closed length is too short");
    if (!(spec.cutoff_mm > 0.0)) return refuse("the cut-off must be positive");
    if (spec.cutoff_mm > std::max(length, closed_length_mm))
        return refuse("the profile of " + core::fixed(std::max(length, closed_length_mm), 3) +
                      " mm is shorter than the cut-off of " + core::fixed(spec.cutoff_mm, 3) + " mm");
    const Profile profile(s_mm, values, closed_length_mm);
    if (spec.kind == FilterKind::spline) return smoothing_spline(profile, spec.cutoff_mm);
    if (spec.kind == FilterKind::robust_gaussian)
        return robust_regression(profile, second_order_width * spec.cutoff_mm);
    const std::vector<double> trust(profile.size(), 1.0);
    return local_regression<1>(profile, first_order_width * spec.cutoff_mm, trust);
}

FilteredZones filter_zones(std::span<const ContourPoint> contour, std::span<const std::optional<double>> values,
                           const ZoneFilters& filters) {
    FilteredZones out{{values.begin(), values.end()}, {}};
    const std::size_t n = contour.size();
    if (n == 0) return out;
    const auto same_stretch = [&](std::size_t i, std::size_t j) {
        return contour[i].zone == contour[j].zone && values[i].has_value() == values[j].has_value();
    };
    std::size_t start = 0;  // of a stretch
    while (start < n && same_stretch(start, (start + n - 1) % n))
        ++start;
    const double round = contour[n - 1].arc_length_mm + (contour[0].position_mm - contour[n - 1].position_mm).norm();
    for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
        const std::size_t first = (start + begin) % n;
        std::vector<double> s, z;
        for (end = begin; end < n && same_stretch((start + end) % n, first); ++end) {
            const std::size_t i = start + end;
            s.push_back(contour[i % n].arc_length_mm + (i >= n ? round : 0.0));
            z.push_back(values[i % n].value_or(0.0));
        }
        if (!values[first]) continue;
        const auto filtered = filter_profile(s, z, filters.at(contour[first].zone));
        if (!filtered) out.refused[static_cast<std::size_t>(contour[first].zone)] = filtered.error().message;
        for (std::size_t k = begin; filtered && k < end; ++k)
            out.values[(start + k) % n] = (*filtered)[k - begin];
    }
    for (std::size_t i = 0; i < n; ++i)
        if (!out.refused[static_cast<std::size_t>(contour[i].zone)].empty()) out.values[i].reset();
    return out;
}

}  // namespace cmm::fitting
