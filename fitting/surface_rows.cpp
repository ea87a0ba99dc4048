// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/edges.hpp"
#include "fitting/offset.hpp"
#include "fitting/small_system.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t searched_row_points = 1600;
constexpr double joint_reach = 2.0;  // from an edge's end, of the end's distance from the nose
constexpr double joint_share = 0.6;  // of the rows that know a joint
/// However well the others foretell a joint, it may lie off them by so much.
constexpr double least_joint_sigma_mm = 0.01;

struct Smoothed {
    std::vector<double> value, sigma;  ///< at each z_k
};

/// The polynomial of least squares of degree up to 3 through what is known at the z_k; those farther from it than six
/// times the median are left out.
Smoothed smoothed_over(std::span<const double> z, std::span<const std::optional<double>> known) {
    const std::size_t n = z.size();
    std::vector<char> use(n);
    std::size_t used = 0;
    for (std::size_t k = 0; k < n; ++k)
        used += static_cast<std::size_t>(use[k] = static_cast<char>(known[k].has_value()));
    const int terms = static_cast<int>(std::clamp<std::size_t>(used / 3 + 1, 1, 4));
    const double middle = 0.5 * (z.front() + z.back()), half = std::max(0.5 * (z.back() - z.front()), 1e-12);
    const auto powers = [&](double at) {
        SmallVector p(terms);
        p[0] = 1.0;
        for (int k = 1; k < terms; ++k)
            p[k] = p[k - 1] * (at - middle) / half;
        return p;
    };
    Smoothed out{std::vector<double>(n), std::vector<double>(n)};
    for (int round = 0; round < 2; ++round) {
        SmallMatrix normal = SmallMatrix::Zero(terms, terms);
        SmallVector rhs = SmallVector::Zero(terms);
        for (std::size_t k = 0; k < n; ++k) {
            if (use[k] == 0) continue;
            const SmallVector p = powers(z[k]);
            normal += p * p.transpose();
            rhs += *known[k] * p;
        }
        const SmallVector solution = solve_small(normal, rhs);
        std::vector<double> off;
        double squares = 0.0;
        for (std::size_t k = 0; k < n; ++k) {
            out.value[k] = solution.dot(powers(z[k]));
            if (use[k] == 0) continue;
            off.push_back(std::abs(*known[k] - out.value[k]));
            squares += off.back() * off.back();
        }
        const double free = std::max(static_cast<double>(off.size()) - terms, 1.0);
        for (std::size_t k = 0; k < n; ++k) {
            const SmallVector p = powers(z[k]);
            out.sigma[k] = std::sqrt(squares / free * p.dot(solve_small(normal, p)));
        }
        const double far = 6.0 * nth_smallest(off, off.size() / 2);
        for (std::size_t k = 0; k < n; ++k)
            if (use[k] != 0 && std::abs(*known[k] - out.value[k]) > far) use[k] = 0;
    }
    return out;
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
    row.find_joints();
    row.le_ = part[edges->le.nose].position;
    row.te_ = part[edges->te.nose].position;
    return row;
}

/// Beside an end of an edge the joint with the largest step counts. It may be farther from the nose than the end is: an
/// ellipse's curvature falls long before it meets the side.
void SurfaceRow::find_joints() {
    const double total = arc_.total();
    const auto distance = [&](double a, double b) {
        const double d = std::abs(a - b);
        return std::min(d, total - d);
    };
    for (const CurvatureStep& joint : smooth_.joints) {
        double t = joint.t;
        const std::size_t span = smooth_.curve.span_of(t);
        const double s = arc_.at(smooth_.curve, {span, t});
        std::optional<std::size_t> nearest;
        for (const std::size_t j : {le_end, te_begin, te_end, le_begin})
            if (!nearest || distance(features_[j], s) < distance(features_[*nearest], s)) nearest = j;
        const std::size_t nose = *nearest == te_begin || *nearest == te_end ? te_nose : le_nose;
        const double reach = joint_reach * distance(features_[*nearest], features_[nose]);
        auto& known = joints_[*nearest];
        if (distance(features_[*nearest], s) > reach || (known && std::abs(joint.step) < std::abs(known->step)))
            continue;
        known = RowJoint{s, joint.step};
    }
}

core::Result<SurfaceRow> SurfaceRow::with_joints(std::vector<KnownJoint> joints) const {
    // Half-way along a side there are none.
    const double total = arc_.total(), side = features_[te_begin] - features_[le_end];
    const double begin_t = parameter(features_[le_end] + 0.5 * (side - total * std::floor(side / total)));
    const double period = smooth_.curve.breaks().back() - smooth_.curve.breaks().front();
    const auto from_begin = [&](double t) { return t < begin_t ? t - begin_t + period : t - begin_t; };
    std::sort(joints.begin(), joints.end(),
              [&](const KnownJoint& a, const KnownJoint& b) { return from_begin(a.t) < from_begin(b.t); });
    auto smooth = smooth_with_joints(smooth_, joints, begin_t);
    if (!smooth) return tl::unexpected(smooth.error());
    SurfaceRow row = *this;
    row.smooth_ = std::move(*smooth);
    row.arc_ = ArcLength(row.smooth_.curve);
    const auto there = [&](double& s_mm) {
        double t = from_begin(parameter(s_mm));
        const std::size_t span = row.smooth_.curve.span_of(t);
        s_mm = row.arc_.at(row.smooth_.curve, {span, t});
    };
    for (double& feature : row.features_)
        there(feature);
    for (auto& joint : row.joints_)
        if (joint) there(joint->s_mm);
    return row;
}

CurvePlace SurfaceRow::place_at(double s_mm) const {
    const double total = arc_.total();
    return arc_.place(smooth_.curve, std::clamp(s_mm - std::floor(s_mm / total) * total, 0.0, total));
}

double SurfaceRow::parameter(double s_mm) const {
    return place_at(s_mm).t;
}

Vec2 SurfaceRow::at(double s_mm) const {
    const CurvePlace place = place_at(s_mm);
    return smooth_.curve.jet_in(place.span, place.t).position;
}

RowAlignment::RowAlignment(std::span<const SurfaceRow> rows) {
    const std::size_t n = rows.size();
    std::vector<double> z(n);
    std::array<std::vector<double>, count> ahead;  // of the LE nose
    const auto from_nose = [&](std::size_t k, double s) {
        const double d = s - rows[k].features()[SurfaceRow::le_nose], l = rows[k].length_mm();
        return d - std::floor(d / l) * l;
    };
    for (std::size_t k = 0; k < n; ++k) {
        z[k] = rows[k].z_mm();
        for (std::size_t j = 0; j < count; ++j)
            ahead[j].push_back(from_nose(k, rows[k].features()[j]));
    }
    // The ends of the edges, as distances from their noses.
    std::array<bool, count> at_joint{};
    for (const auto& [end, nose] : {std::pair{SurfaceRow::le_end, SurfaceRow::le_nose},
                                    {SurfaceRow::te_begin, SurfaceRow::te_nose},
                                    {SurfaceRow::te_end, SurfaceRow::te_nose},
                                    {SurfaceRow::le_begin, SurfaceRow::le_nose}}) {
        std::size_t known = 0;
        for (const SurfaceRow& row : rows)
            known += static_cast<std::size_t>(row.joints()[end].has_value());
        at_joint[end] = static_cast<double>(known) > joint_share * static_cast<double>(n);
        const bool before_le = end == SurfaceRow::le_begin;
        const auto origin = [&](std::size_t k) { return before_le ? rows[k].length_mm() : ahead[nose][k]; };
        std::vector<std::optional<double>> apart(n);
        for (std::size_t k = 0; k < n; ++k) {
            const auto& joint = rows[k].joints()[end];
            if (!at_joint[end])
                apart[k] = ahead[end][k] - origin(k);
            else if (joint)
                apart[k] = from_nose(k, joint->s_mm) - origin(k);
        }
        const auto smooth = smoothed_over(z, apart);
        for (std::size_t k = 0; k < n; ++k)
            ahead[end][k] = origin(k) + smooth.value[k];
        if (at_joint[end]) joint_sigma_mm_[end] = smooth.sigma;
    }
    for (std::size_t k = 0; k < n; ++k)
        period_ += rows[k].length_mm() / static_cast<double>(n);
    for (std::size_t j = 0; j < count; ++j)
        for (std::size_t k = 0; k < n; ++k)
            u_[j] += ahead[j][k] / rows[k].length_mm() * period_ / static_cast<double>(n);
    u_[count] = period_;
    for (std::size_t j = 0; j < count; ++j)
        if (at_joint[j]) joints_.push_back(u_[j]);
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

std::vector<RowAlignment::CommonJoint> RowAlignment::joints_on(std::size_t row) const {
    std::vector<CommonJoint> joints;
    for (std::size_t j = 0; j < count; ++j)
        if (!joint_sigma_mm_[j].empty())
            joints.push_back({static_cast<SurfaceRow::Feature>(j), maps_[row].s[j], joint_sigma_mm_[j][row]});
    return joints;
}

double RowAlignment::arc_length(std::size_t row, double u) const {
    const Map& map = maps_[row];
    const auto above = std::upper_bound(u_.begin() + 1, u_.end() - 1, u);
    const auto j = static_cast<std::size_t>(above - u_.begin()) - 1;
    const double h = u_[j + 1] - u_[j], w = (u - u_[j]) / h;
    const double a = map.s[j], b = map.s[j + 1], p = h * map.slope[j], q = h * map.slope[j + 1];
    return a + w * (p + w * (3.0 * (b - a) - 2.0 * p - q + w * (2.0 * (a - b) + p + q)));
}

std::vector<SurfaceRow> settle_joints(std::span<const SurfaceRow> rows) {
    if (rows.size() < 2) return {rows.begin(), rows.end()};
    const RowAlignment alignment(rows);
    std::array<double, SurfaceRow::feature_count> usual{};  // step
    for (const auto& joint : alignment.joints_on(0)) {
        std::vector<double> steps;
        for (const SurfaceRow& row : rows)
            if (const auto& own = row.joints()[joint.end]) steps.push_back(own->step);
        usual[joint.end] = nth_smallest(steps, steps.size() / 2);
    }
    std::vector<SurfaceRow> settled;
    settled.reserve(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
        std::vector<KnownJoint> joints;
        for (const auto& joint : alignment.joints_on(k))
            joints.push_back(
                {rows[k].parameter(joint.s_mm), usual[joint.end], std::max(joint.sigma_mm, least_joint_sigma_mm)});
        if (!joints.empty())
            if (auto row = rows[k].with_joints(std::move(joints))) {
                settled.push_back(std::move(*row));
                continue;
            }
        settled.push_back(rows[k]);
    }
    return settled;
}

}  // namespace cmm::fitting
