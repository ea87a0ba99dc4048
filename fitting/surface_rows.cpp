// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "fitting/closest_point.hpp"
#include "fitting/edges.hpp"
#include "fitting/offset.hpp"
#include "fitting/over_rows.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t searched_row_points = 400;
constexpr std::size_t rows_that_tell_noses = 6;
constexpr double far_nose_medians = 6.0, far_nose_mm = 0.05;  // of a nose from where the others have it

}  // namespace

core::Result<SurfaceRow> SurfaceRow::make(SmoothCurve smooth, double z_mm, double ball_radius_mm,
                                          const std::optional<Vec2>& le_hint, const std::optional<Vec2>& te_hint) {
    if (!std::isfinite(z_mm) || !(ball_radius_mm >= 0.0) || !std::isfinite(ball_radius_mm))
        return core::fail(core::ErrorCode::fit_not_evaluable, "surface row: height and ball radius must be numbers");
    SurfaceRow row;
    row.smooth_ = std::move(smooth);
    row.arc_ = ArcLength(row.smooth_.curve);
    const auto part = offset_inwards(row.smooth_.curve, ball_radius_mm, searched_row_points).points;
    const auto edges = find_edges(part, le_hint, te_hint);
    if (!edges) return tl::unexpected(edges.error());
    row.features_.z_mm = z_mm;
    row.features_.length_mm = row.arc_.total();
    const auto place = [&](std::size_t i) { return row.arc_length(part[i].t); };
    const PiecewiseCubic& curve = row.smooth_.curve;
    const auto nose = [&](const EdgeRegion& edge) {
        const double t = part[edge.nose].t, step = curve.ahead(part[(edge.nose + part.size() - 1) % part.size()].t, t);
        return row.arc_length(curve.wrap(t - edge.nose_share * step));
    };
    row.features_.s_mm = {nose(edges->le), place(edges->le.end), place(edges->te.begin),
                          nose(edges->te), place(edges->te.end), place(edges->le.begin)};
    row.find_joints();
    row.le_ = part[edges->le.nose].position;
    row.te_ = part[edges->te.nose].position;
    return row;
}

void SurfaceRow::find_joints() {
    std::vector<RowJoint> found;
    for (const CurvatureStep& joint : smooth_.joints)
        found.push_back({arc_length(joint.told_t), joint.told_sigma_mm, joint.step});
    features_.set_joints(found);
}

SurfaceRow SurfaceRow::with(SmoothCurve smooth, double begin_mm) const {
    SurfaceRow row;
    row.smooth_ = std::move(smooth);
    row.arc_ = ArcLength(row.smooth_.curve);
    row.features_ = features_;
    row.features_.length_mm = row.arc_.total();
    const double begin_t = parameter(begin_mm);
    for (double& s : row.features_.s_mm)
        s = row.arc_length(parameter(s) - begin_t);
    row.find_joints();
    row.le_ = le_;
    row.te_ = te_;
    return row;
}

double SurfaceRow::in_first_turn(double s_mm) const {
    const double total = arc_.total();
    return std::clamp(s_mm - std::floor(s_mm / total) * total, 0.0, total);
}

double SurfaceRow::parameter(double s_mm) const {
    return arc_.place(smooth_.curve, in_first_turn(s_mm)).t;
}

double SurfaceRow::arc_length(double t) const {
    const std::size_t span = smooth_.curve.span_of(t);
    return arc_.at(smooth_.curve, {span, t});
}

Vec2 SurfaceRow::at(double s_mm) const {
    const CurvePlace place = arc_.place_near(in_first_turn(s_mm));
    return smooth_.curve.jet_in(place.span, place.t).position;
}

namespace {

/// Where the others have the nose of a row whose own lies elsewhere, as that of a row with a dent beside it does.
void take_noses_of_others(std::span<const SurfaceRow> rows, RowFeatures::Feature nose,
                          std::vector<RowFeatures>& features) {
    if (rows.size() < rows_that_tell_noses) return;
    std::vector<double> z;
    std::array<std::vector<std::optional<Known>>, 2> place;
    for (const SurfaceRow& row : rows) {
        z.push_back(row.z_mm());
        const Vec2 p = row.at(row.features().s_mm[nose]);
        place[0].push_back(Known{p.x()});
        place[1].push_back(Known{p.y()});
    }
    const auto x = smoothed_over(z, place[0]).value, y = smoothed_over(z, place[1]).value;
    std::vector<double> off;
    for (std::size_t k = 0; k < rows.size(); ++k)
        off.push_back(std::hypot(place[0][k]->value - x[k], place[1][k]->value - y[k]));
    std::vector<double> sorted = off;
    const double far = far_nose_medians * nth_smallest(sorted, sorted.size() / 2) + far_nose_mm;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        if (off[k] <= far) continue;
        const ClosestPointIndex index(rows[k].smooth().curve);
        features[k].s_mm[nose] = rows[k].arc_length(index.closest({x[k], y[k]}).t);
    }
}

}  // namespace

std::size_t usual_row(std::span<const SurfaceRow> rows) {
    std::array<std::size_t, 3> candidates{rows.size() / 4, rows.size() / 2, 3 * rows.size() / 4};
    std::nth_element(candidates.begin(), candidates.begin() + 1, candidates.end(), [&](std::size_t a, std::size_t b) {
        return rows[a].smooth().curve.spans() < rows[b].smooth().curve.spans();
    });
    return candidates[1];
}

std::vector<RowFeatures> features_of(std::span<const SurfaceRow> rows) {
    std::vector<RowFeatures> features;
    for (const SurfaceRow& row : rows)
        features.push_back(row.features());
    for (const auto nose : {RowFeatures::le_nose, RowFeatures::te_nose})
        take_noses_of_others(rows, nose, features);
    return features;
}

}  // namespace cmm::fitting
