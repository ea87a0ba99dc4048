// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/edges.hpp"
#include "fitting/offset.hpp"
#include "fitting/small_system.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t searched_row_points = 1600;

/// The polynomial of least squares of degree up to 3 at the z_k, in place.
void smooth_over(std::span<const double> z, std::span<double> values) {
    const std::size_t n = z.size();
    const int terms = static_cast<int>(std::clamp<std::size_t>(n / 3 + 1, 1, 4));
    const double middle = 0.5 * (z.front() + z.back()), half = std::max(0.5 * (z.back() - z.front()), 1e-12);
    SmallMatrix normal = SmallMatrix::Zero(terms, terms);
    SmallVector rhs = SmallVector::Zero(terms);
    const auto powers = [&](double at) {
        SmallVector p(terms);
        p[0] = 1.0;
        for (int k = 1; k < terms; ++k)
            p[k] = p[k - 1] * (at - middle) / half;
        return p;
    };
    for (std::size_t k = 0; k < n; ++k) {
        const SmallVector p = powers(z[k]);
        normal += p * p.transpose();
        rhs += values[k] * p;
    }
    const SmallVector solution = solve_small(normal, rhs);
    for (std::size_t k = 0; k < n; ++k)
        values[k] = solution.dot(powers(z[k]));
}

}  // namespace

core::Result<SurfaceRow> SurfaceRow::make(SmoothCurve smooth, double z_mm, double ball_radius_mm,
                                          const std::optional<Vec2>& le_hint, const std::optional<Vec2>& te_hint) {
    if (!std::isfinite(z_mm) || !(ball_radius_mm >= 0.0) || !std::isfinite(ball_radius_mm))
        return core::fail(core::ErrorCode::fit_not_evaluable, "surface row: height and ball radius must be numbers");
    SurfaceRow row;
    row.z_mm_ = z_mm;
    row.smooth_ = std::move(smooth);
    row.arc_ = ArcLength(row.smooth_.curve);
    const auto part = offset_inwards(row.smooth_.curve, ball_radius_mm, searched_row_points).points;
    const auto edges = find_edges(part, le_hint, te_hint);
    if (!edges) return tl::unexpected(edges.error());
    const auto place = [&](std::size_t i) {
        double t = part[i].t;
        const std::size_t span = row.smooth_.curve.span_of(t);
        return row.arc_.at(row.smooth_.curve, {span, t});
    };
    row.features_ = {place(edges->le.nose), place(edges->le.end), place(edges->te.begin),
                     place(edges->te.nose), place(edges->te.end), place(edges->le.begin)};
    row.le_ = part[edges->le.nose].position;
    row.te_ = part[edges->te.nose].position;
    return row;
}

Vec2 SurfaceRow::at(double s_mm) const {
    const double total = arc_.total();
    const double s = std::clamp(s_mm - std::floor(s_mm / total) * total, 0.0, total);
    const CurvePlace place = arc_.place(smooth_.curve, s);
    return smooth_.curve.jet_in(place.span, place.t).position;
}

RowAlignment::RowAlignment(std::span<const SurfaceRow> rows) {
    const std::size_t n = rows.size();
    std::vector<double> z(n);
    std::array<std::vector<double>, count> ahead;  // of the LE nose
    for (std::size_t k = 0; k < n; ++k) {
        z[k] = rows[k].z_mm();
        for (std::size_t j = 0; j < count; ++j) {
            const double s = rows[k].features()[j] - rows[k].features()[SurfaceRow::le_nose], l = rows[k].length_mm();
            ahead[j].push_back(s - std::floor(s / l) * l);
        }
    }
    // The ends of the edges, as distances from their noses.
    for (const auto& [end, nose] : {std::pair{SurfaceRow::le_end, SurfaceRow::le_nose},
                                    {SurfaceRow::te_begin, SurfaceRow::te_nose},
                                    {SurfaceRow::te_end, SurfaceRow::te_nose}}) {
        std::vector<double> apart(n);
        for (std::size_t k = 0; k < n; ++k)
            apart[k] = ahead[end][k] - ahead[nose][k];
        smooth_over(z, apart);
        for (std::size_t k = 0; k < n; ++k)
            ahead[end][k] = ahead[nose][k] + apart[k];
    }
    std::vector<double> before(n);
    for (std::size_t k = 0; k < n; ++k)
        before[k] = rows[k].length_mm() - ahead[SurfaceRow::le_begin][k];
    smooth_over(z, before);
    for (std::size_t k = 0; k < n; ++k)
        ahead[SurfaceRow::le_begin][k] = rows[k].length_mm() - before[k];
    for (std::size_t k = 0; k < n; ++k)
        period_ += rows[k].length_mm() / static_cast<double>(n);
    for (std::size_t j = 0; j < count; ++j)
        for (std::size_t k = 0; k < n; ++k)
            u_[j] += ahead[j][k] / rows[k].length_mm() * period_ / static_cast<double>(n);
    u_[count] = period_;
    for (std::size_t k = 0; k < n; ++k) {
        Map map;
        for (std::size_t j = 0; j < count; ++j)
            map.s[j] = ahead[j][k];
        map.s[count] = rows[k].length_mm();
        std::array<double, count> secant;
        for (std::size_t j = 0; j < count; ++j)
            secant[j] = (map.s[j + 1] - map.s[j]) / (u_[j + 1] - u_[j]);
        for (std::size_t j = 0; j <= count; ++j) {
            const double left = secant[(j + count - 1) % count], right = secant[j % count];
            map.slope[j] = left * right > 0.0 ? 2.0 * left * right / (left + right) : 0.0;
        }
        for (double& s : map.s)
            s += rows[k].features()[SurfaceRow::le_nose];
        maps_.push_back(map);
    }
}

double RowAlignment::arc_length(std::size_t row, double u) const {
    const Map& map = maps_[row];
    const auto above = std::upper_bound(u_.begin() + 1, u_.end() - 1, u);
    const auto j = static_cast<std::size_t>(above - u_.begin()) - 1;
    const double h = u_[j + 1] - u_[j], w = (u - u_[j]) / h;
    const double a = map.s[j], b = map.s[j + 1], p = h * map.slope[j], q = h * map.slope[j + 1];
    return a + w * (p + w * (3.0 * (b - a) - 2.0 * p - q + w * (2.0 * (a - b) + p + q)));
}

}  // namespace cmm::fitting
