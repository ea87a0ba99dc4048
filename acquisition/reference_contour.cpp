// SPDX-License-Identifier: Apache-2.0
#include "acquisition/reference_contour.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fitting/offset.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using fitting::ContourPoint;

// A foot whose normal is more than 60 degrees away lies on another side of the blade.
constexpr double same_side_cosine = 0.5;
constexpr std::size_t station_count = 2400;
constexpr double texture_mm = 5e-3;  // in a hollow less deep than this the ball's own arc is the nominal

/// Along the closed polygon up to each of its points, and all of it.
std::vector<double> lengths_to(const std::vector<Vector2d>& points) {
    const std::size_t n = points.size();
    std::vector<double> length(n + 1, 0.0);
    for (std::size_t i = 0; i < n; ++i)
        length[i + 1] = length[i] + (points[(i + 1) % n] - points[i]).norm();
    return length;
}

/// The lean at even shares of the contour's length: that of the point before.
std::vector<double> leans_by_length(const NominalContour& contour) {
    const std::size_t n = contour.points.size();
    if (contour.leans_rad.size() != n) return std::vector<double>(station_count, contour.lean_rad);
    const auto length = lengths_to(contour.points);
    std::vector<double> leans;
    std::size_t i = 0;
    for (std::size_t k = 0; k < station_count; ++k) {
        const double at = length[n] * static_cast<double>(k) / static_cast<double>(station_count);
        while (i + 1 < n && length[i + 1] <= at)
            ++i;
        leans.push_back(contour.leans_rad[i]);
    }
    return leans;
}

}  // namespace

ReferenceContour::ReferenceContour(const NominalContour& contour, fitting::ClosedCurve curve, double ball_radius_mm)
    : points_(contour.points),
      knows_lean_(contour.leans_rad.size() == contour.points.size()),
      curve_(std::move(curve)),
      hollows_(fitting::find_hollows(curve_.spline(), ball_radius_mm)) {
    const auto leans = leans_by_length(contour);
    stations_.reserve(station_count);
    for (std::size_t i = 0; i < station_count; ++i) {
        const double s = station_mm(i), t = curve_.parameter_at(s);
        const auto jet = curve_.spline().jet(t);
        const bool reached =
            std::none_of(hollows_.begin(), hollows_.end(), [t](const auto& hollow) { return hollow.holds(t); });
        stations_.push_back({jet.position, jet.right_normal(), leans[i],
                             fitting::lean_error(ball_radius_mm, leans[i]).in_plane_mm,
                             fitting::lean_error(ball_radius_mm, std::abs(leans[i]) + lean_doubt_rad).in_plane_mm,
                             knows_lean_ ? std::tan(leans[i]) : 0.0, reached});
    }
    if (contour.tolerances.size() != points_.size()) return;
    tolerances_ = contour.tolerances;
    tolerance_share_ = lengths_to(points_);
    const double length = tolerance_share_.back();
    for (double& share : tolerance_share_)
        share /= length;
}

PointTolerance ReferenceContour::tolerance_at(double s_mm) const {
    const double share = curve_.wrap(s_mm) / curve_.length();
    const auto after = std::upper_bound(tolerance_share_.begin() + 1, tolerance_share_.end() - 1, share);
    const auto i = static_cast<std::size_t>(after - tolerance_share_.begin()) - 1;
    const double span = tolerance_share_[i + 1] - tolerance_share_[i];
    const double w = span > 0.0 ? std::clamp((share - tolerance_share_[i]) / span, 0.0, 1.0) : 0.0;
    const PointTolerance &a = tolerances_[i], &b = tolerances_[(i + 1) % tolerances_.size()];
    return {(1.0 - w) * a.below_mm + w * b.below_mm, (1.0 - w) * a.above_mm + w * b.above_mm};
}

double ReferenceContour::station_mm(std::size_t i) const {
    return curve_.length() * static_cast<double>(i) / static_cast<double>(station_count);
}

const fitting::Hollow* ReferenceContour::hollow_below(const ContourPoint& point) const {
    const auto below = std::find_if(hollows_.begin(), hollows_.end(), [&](const auto& hollow) {
        return hollow.bridges(point.position_mm, point.normal);
    });
    return below != hollows_.end() ? &*below : nullptr;
}

const ReferenceContour::Station& ReferenceContour::station_at(double s_mm) const {
    const auto i = static_cast<std::size_t>(std::lround(s_mm / curve_.length() * static_cast<double>(station_count)));
    return stations_[i % station_count];
}

/// The station that is nearest on the point's side, among those that the ball reaches.
const ReferenceContour::Station* ReferenceContour::nearest_station(const ContourPoint& point) const {
    const Station* best = nullptr;
    double best_squared = std::numeric_limits<double>::max();
    for (const Station& station : stations_) {
        const double squared = (station.position - point.position_mm).squaredNorm();
        if (squared >= best_squared || !station.reached || station.normal.dot(point.normal) < same_side_cosine)
            continue;
        best = &station;
        best_squared = squared;
    }
    return best;
}

/// The nearest foot of all is nearly always on the point's side. Where it is not (a thin edge, a hollow) the search
/// goes over the stations; where no normal agrees either, the nearest foot is all there is.
ReferenceContour::Match ReferenceContour::match(const ContourPoint& point, const fitting::ClosestPoint& foot) const {
    const auto good = [&](const fitting::ClosestPoint& f) {
        return f.normal.dot(point.normal) >= same_side_cosine && station_at(f.s_mm).reached;
    };
    if (good(foot)) return {foot.distance_mm, foot.s_mm, &station_at(foot.s_mm)};
    const Station* station = nearest_station(point);
    if (station == nullptr) return {foot.distance_mm, foot.s_mm, nullptr};
    const Vector2d& p = point.position_mm;
    const double s_mm = station_mm(static_cast<std::size_t>(station - stations_.data()));
    const auto beside = curve_.closest(p, s_mm);
    if (good(beside)) return {beside.distance_mm, beside.s_mm, station};
    return {(p - station->position).dot(station->normal), s_mm, station};
}

double ReferenceContour::Match::offset_error_mm(Lean lean) const {
    if (station == nullptr) return 0.0;
    return lean == Lean::doubted ? station->doubted_error_mm : station->offset_error_mm;
}

double ReferenceContour::Match::rise() const {
    return station == nullptr ? 0.0 : station->rise;
}

/// None where the ball does not reach the nominal.
std::optional<double> ReferenceContour::deviation(const ContourPoint& point, const Match& matched) const {
    const fitting::Hollow* hollow = hollow_below(point);
    if (hollow == nullptr) return matched.deviation_mm;
    if (hollow->depth_mm >= texture_mm) return std::nullopt;
    return hollow->radius_mm - (point.position_mm - hollow->centre).norm();
}

ReferenceContour::Comparison ReferenceContour::compare(const Vector2d& position_mm, const Vector2d& normal,
                                                       std::optional<double> near_mm) const {
    ContourPoint point;
    point.position_mm = position_mm;
    point.normal = normal;
    const Match matched = match(point, curve_.closest(position_mm, near_mm));
    return {deviation(point, matched), matched.offset_error_mm(Lean::nominal), matched.offset_error_mm(Lean::doubted),
            matched.s_mm, matched.rise()};
}

Eigen::Vector3d ReferenceContour::touched_normal(const Vector2d& centre_mm, const Vector2d& outward) const {
    ContourPoint point;
    point.position_mm = centre_mm;
    point.normal = outward;
    const double s_mm = match(point, curve_.closest(centre_mm)).s_mm;
    const double lean = station_at(s_mm).lean_rad;
    const Vector2d level = std::cos(lean) * curve_.evaluate(s_mm).normal;
    return {level.x(), level.y(), std::sin(lean)};
}

std::vector<ReferenceContour::Match> ReferenceContour::matches(std::span<const ContourPoint> contour) const {
    std::vector<Vector2d> positions;
    for (const auto& point : contour)
        positions.push_back(point.position_mm);
    std::vector<fitting::ClosestPoint> feet(contour.size());
    curve_.closest(positions, feet);
    std::vector<Match> out;
    out.reserve(contour.size());
    for (std::size_t i = 0; i < contour.size(); ++i)
        out.push_back(match(contour[i], feet[i]));
    return out;
}

std::vector<double> ReferenceContour::leans_along(std::span<const ContourPoint> contour) const {
    std::vector<double> leans;
    for (const Match& matched : matches(contour))
        leans.push_back(station_at(matched.s_mm).lean_rad);
    return leans;
}

std::vector<std::optional<double>> ReferenceContour::compare(std::span<ContourPoint> contour, Lean lean) const {
    const auto matched_to = matches(contour);
    std::vector<std::optional<double>> deviations(contour.size());
    for (std::size_t i = 0; i < contour.size(); ++i) {
        ContourPoint& point = contour[i];
        const Match& matched = matched_to[i];
        if (!point.lean_rad) {
            const double error_mm = matched.offset_error_mm(lean);
            point.u95_mm += error_mm - point.offset_error_mm;
            point.offset_error_mm = error_mm;
            point.rise = matched.rise();
        }
        if (point.reached && point.measured) deviations[i] = deviation(point, matched);
    }
    return deviations;
}

}  // namespace cmm::acquisition
