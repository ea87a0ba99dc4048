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
constexpr std::size_t window_stations = 6;  // either way; a contour advances by about one from point to point
constexpr double undirected_mm = 1e-5;      // nearer than this the way to the foot says nothing about its normal

/// The lean at even shares of the contour's length: that of the point before.
std::vector<double> leans_by_length(const NominalContour& contour) {
    const std::size_t n = contour.points.size();
    if (contour.leans_rad.size() != n) return std::vector<double>(station_count, contour.lean_rad);
    std::vector<double> length(n + 1, 0.0);
    for (std::size_t i = 0; i < n; ++i)
        length[i + 1] = length[i] + (contour.points[(i + 1) % n] - contour.points[i]).norm();
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
      curve_(std::move(curve)),
      hollows_(fitting::find_hollows(curve_.spline(), ball_radius_mm)) {
    const auto leans = leans_by_length(contour);
    stations_.reserve(station_count);
    for (std::size_t i = 0; i < station_count; ++i) {
        const double s = station_mm(i), t = curve_.parameter_at(s);
        const auto jet = curve_.spline().jet(t);
        const bool reached =
            std::none_of(hollows_.begin(), hollows_.end(), [t](const auto& hollow) { return hollow.holds(t); });
        stations_.push_back(
            {jet.position, jet.right_normal(), fitting::lean_error(ball_radius_mm, leans[i]).in_plane_mm, reached});
    }
}

double ReferenceContour::station_mm(std::size_t i) const {
    return curve_.length() * static_cast<double>(i) / static_cast<double>(station_count);
}

/// Consecutive points of a contour are near each other: the last foot's surroundings are searched first.
class ReferenceContour::Walk {
  public:
    static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

    explicit Walk(const ReferenceContour& reference) : stations_(reference.stations_) {}

    /// The nearest station on the point's side; `none` where no normal agrees.
    std::size_t to(const ContourPoint& point) {
        auto best = nearest(point, last_ + station_count - window_stations, 2 * window_stations + 1);
        const auto ahead = (best + station_count - last_) % station_count;
        const bool at_border = ahead == window_stations || ahead == station_count - window_stations;
        if (!started_ || best == none || at_border) best = nearest(point, 0, station_count);
        if (best == none) return none;
        started_ = true;
        last_ = best;
        return best;
    }

  private:
    std::size_t nearest(const ContourPoint& point, std::size_t first, std::size_t count) const {
        std::size_t best = none;
        double best_squared = std::numeric_limits<double>::max();
        for (std::size_t k = 0; k < count; ++k) {
            const auto i = (first + k) % station_count;
            const double squared = (stations_[i].position - point.position_mm).squaredNorm();
            if (squared < best_squared && stations_[i].reached &&
                stations_[i].normal.dot(point.normal) >= same_side_cosine) {
                best = i;
                best_squared = squared;
            }
        }
        return best;
    }

    const std::vector<Station>& stations_;
    std::size_t last_ = 0;
    bool started_ = false;
};

/// The way from the foot to the point is the normal already.
Vector2d ReferenceContour::normal_at(const fitting::ClosestPoint& foot, const Vector2d& point) const {
    if (std::abs(foot.distance_mm) < undirected_mm) return curve_.evaluate(foot.s_mm).normal;
    return (point - foot.foot) / foot.distance_mm;
}

std::vector<std::optional<double>> ReferenceContour::compare(std::span<ContourPoint> contour) const {
    std::vector<std::optional<double>> deviations;
    deviations.reserve(contour.size());
    Walk walk(*this);
    for (auto& point : contour) {
        const Vector2d& p = point.position_mm;
        const auto nearest = walk.to(point);
        const bool in_hollow = !point.reached || std::any_of(hollows_.begin(), hollows_.end(), [&](const auto& hollow) {
            return hollow.bridges(p, point.normal);
        });
        if (nearest == Walk::none) {
            deviations.push_back(in_hollow ? std::nullopt : std::optional(curve_.closest(p).distance_mm));
            continue;
        }
        const Station& station = stations_[nearest];
        point.offset_error_mm = station.offset_error_mm;
        point.u95_mm += point.offset_error_mm;
        if (in_hollow) {
            deviations.emplace_back();
            continue;
        }
        const auto foot = curve_.closest(p, station_mm(nearest));
        const bool same_side = normal_at(foot, p).dot(point.normal) >= same_side_cosine;
        deviations.emplace_back(same_side ? foot.distance_mm : (p - station.position).dot(station.normal));
    }
    return deviations;
}

}  // namespace cmm::acquisition
