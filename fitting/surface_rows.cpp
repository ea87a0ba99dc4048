// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "fitting/edges.hpp"
#include "fitting/offset.hpp"
#include "fitting/over_rows.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t searched_row_points = 400;

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

constexpr int facing_halvings = 30;  // of an edge: nanometres of some millimetres

double angle_between(double a, double b) {
    return std::remainder(b - a, 2.0 * std::numbers::pi);
}
double angle_of(const Vec2& v) {
    return std::atan2(v.y(), v.x());
}
/// Which way the row faces at a parameter of its curve: outwards.
double facing_at(const SurfaceRow& row, double t) {
    const Vec2 along = row.smooth().curve.jet(t).d1;
    return angle_of({along.y(), -along.x()});
}

/// A nose is where its edge faces in a direction to the chord that changes smoothly over the rows: a round edge does
/// not tell its nose from the places beside it, but which way it faces there.
void face_together(std::span<const SurfaceRow> rows, RowFeatures::Feature nose, std::vector<RowFeatures>& features) {
    const bool le = nose == RowFeatures::le_nose;
    const auto begin = le ? RowFeatures::le_begin : RowFeatures::te_begin;
    const auto end = le ? RowFeatures::le_end : RowFeatures::te_end;
    const auto other = le ? RowFeatures::te_nose : RowFeatures::le_nose;
    std::vector<double> z, chord;
    std::vector<std::optional<Known>> facing;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const auto& s = features[k].s_mm;
        z.push_back(rows[k].z_mm());
        chord.push_back(angle_of(rows[k].at(s[nose]) - rows[k].at(s[other])));
        facing.push_back(Known{angle_between(chord[k], facing_at(rows[k], rows[k].parameter(s[nose])))});
    }
    const auto common = smoothed_over(z, facing).value;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const PiecewiseCubic& curve = rows[k].smooth().curve;
        auto& s = features[k].s_mm;
        const double from = rows[k].parameter(s[begin]), width = curve.ahead(from, rows[k].parameter(s[end]));
        const auto beyond = [&](double ahead) {
            return angle_between(chord[k] + common[k], facing_at(rows[k], curve.wrap(from + ahead)));
        };
        if (!(beyond(0.0) < 0.0 && beyond(width) > 0.0)) continue;
        double low = 0.0, high = width;
        for (int halving = 0; halving < facing_halvings; ++halving) {
            const double middle = 0.5 * (low + high);
            (beyond(middle) < 0.0 ? low : high) = middle;
        }
        s[nose] = rows[k].arc_length(curve.wrap(from + 0.5 * (low + high)));
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
        face_together(rows, nose, features);
    return features;
}

}  // namespace cmm::fitting
