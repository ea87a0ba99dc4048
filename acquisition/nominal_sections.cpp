// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "acquisition/loft.hpp"
#include "acquisition/nominal_kinds.hpp"
#include "acquisition/profile_starts.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;
using core::fail;
using Profile = std::vector<Eigen::Vector3d>;

constexpr double same_plane_mm = 1e-3;
constexpr double same_point_mm = 1e-4;  // files round
constexpr std::size_t least_points = 8;
constexpr std::size_t curvature_samples_per_span = 4;

Eigen::Vector3d centre_of(const Profile& profile) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& p : profile)
        sum += p;
    return sum / static_cast<double>(profile.size());
}

/// The axis along which the centres spread most; sections that do not spread lie across z.
Span span_of(const std::vector<Profile>& profiles) {
    Eigen::Vector3d low = centre_of(profiles.front()), high = low;
    for (const auto& profile : profiles) {
        const Eigen::Vector3d centre = centre_of(profile);
        low = low.cwiseMin(centre);
        high = high.cwiseMax(centre);
    }
    Eigen::Index axis = 2;
    if ((high - low).maxCoeff(&axis) < same_plane_mm) return Span::z;
    return axis == 0 ? Span::x : axis == 1 ? Span::y : Span::z;
}

std::vector<Eigen::Vector2d> seen_along_z(const Profile& profile) {
    std::vector<Eigen::Vector2d> plane;
    plane.reserve(profile.size());
    for (const auto& p : profile)
        plane.emplace_back(p.head<2>());
    return plane;
}

bool is_planar(const Profile& profile) {
    const auto [low, high] =
        std::minmax_element(profile.begin(), profile.end(), [](const auto& a, const auto& b) { return a.z() < b.z(); });
    return high->z() - low->z() < same_plane_mm;
}

bool same_point(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return (a - b).norm() < same_point_mm;
}

/// Leaves out a point that repeats the one before it in every one of the profiles, which have as many points each.
void drop_repeats(std::span<Profile> profiles) {
    for (std::size_t i = profiles.front().size(); i-- > 1 && profiles.front().size() > least_points;) {
        if (!std::all_of(profiles.begin(), profiles.end(), [i](const auto& p) { return same_point(p[i - 1], p[i]); }))
            continue;
        for (auto& profile : profiles)
            profile.erase(profile.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

double perimeter(const Profile& profile) {
    double length = 0.0;
    for (std::size_t i = 0; i < profile.size(); ++i)
        length += (profile[(i + 1) % profile.size()] - profile[i]).norm();
    return length;
}

CubicSpline spline_through(const Profile& profile) {
    std::vector<double> knots{0.0};
    for (std::size_t i = 0; i < profile.size(); ++i) {
        knots.push_back(knots.back() + (profile[(i + 1) % profile.size()] - profile[i]).norm());
    }
    return CubicSpline::periodic(std::move(knots), profile);
}

/// Parameter of the largest curvature; with `near`, among the points of the half of the profile that lies on that side.
/// An edge that is an arc has no single sharpest point: the middle of what comes near the largest is taken.
double sharpest(const CubicSpline& spline, const Eigen::Vector3d& centre, const std::optional<Eigen::Vector3d>& near) {
    constexpr double near_largest = 0.8;
    const auto& knots = spline.knots();
    const double period = knots.back() - knots.front();
    const std::size_t n = std::max<std::size_t>(2000, curvature_samples_per_span * knots.size());
    const auto parameter = [&](std::size_t i) { return period * static_cast<double>(i) / static_cast<double>(n); };
    std::vector<double> curvature(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
        const double t = parameter(i);
        if (near && (spline.value(t) - centre).head<2>().dot(near->head<2>()) <= 0.0) continue;
        const Eigen::Vector3d d1 = spline.first(t);
        curvature[i] = d1.cross(spline.second(t)).norm() / std::pow(d1.norm(), 3);
    }
    const auto top = static_cast<std::size_t>(std::max_element(curvature.begin(), curvature.end()) - curvature.begin());
    std::size_t before = 0, after = 0;
    while (before < n && curvature[(top + n - before - 1) % n] > near_largest * curvature[top])
        ++before;
    while (after < n && curvature[(top + after + 1) % n] > near_largest * curvature[top])
        ++after;
    return parameter(top) + 0.5 * (parameter(after) - parameter(before));
}

/// `count` points at equal arc length, from parameter `start` on.
Profile resampled(const CubicSpline& spline, double start, std::size_t count) {
    const auto& knots = spline.knots();
    const double period = knots.back() - knots.front();
    const std::size_t fine = std::max<std::size_t>(8 * count, 20 * knots.size());
    std::vector<double> length(fine + 1, 0.0);
    const auto parameter = [&](std::size_t i) {
        return start + period * static_cast<double>(i) / static_cast<double>(fine);
    };
    for (std::size_t i = 0; i < fine; ++i) {
        length[i + 1] = length[i] + (spline.value(parameter(i + 1)) - spline.value(parameter(i))).norm();
    }
    Profile points;
    std::size_t i = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double target = length.back() * static_cast<double>(k) / static_cast<double>(count);
        while (length[i + 1] < target)
            ++i;
        const double part = (target - length[i]) / (length[i + 1] - length[i]);
        points.push_back(spline.value(parameter(i) + part * period / static_cast<double>(fine)));
    }
    return points;
}

std::size_t common_count(const std::vector<Profile>& profiles) {
    std::size_t count = 1000;
    for (const auto& profile : profiles)
        count = std::max(count, 4 * profile.size());
    return count;
}

/// Profiles of different point counts get a common one, by arc length from the sharpest point. Two edges of nearly
/// equal sharpness must not change places from profile to profile: after the first, the same end is meant.
std::vector<Profile> from_the_sharpest(std::vector<Profile> profiles) {
    const std::size_t count = common_count(profiles);
    std::optional<Eigen::Vector3d> end;
    for (auto& profile : profiles) {
        const auto spline = spline_through(profile);
        const Eigen::Vector3d centre = centre_of(profile);
        const double start = sharpest(spline, centre, end);
        end = spline.value(start) - centre;
        profile = resampled(spline, start, count);
    }
    return profiles;
}

/// By arc length from the place opposite the first profile's first point; `first` is the point next to it.
std::vector<Profile> from_opposite_places(std::vector<Profile> profiles, const std::vector<std::size_t>& first) {
    constexpr std::size_t compared = 400;
    const std::size_t count = common_count(profiles);
    std::vector<Eigen::Vector2d> below;
    for (std::size_t k = 0; k < profiles.size(); ++k) {
        const auto spline = spline_through(profiles[k]);
        double start = spline.knots()[first[k]];
        auto even = seen_along_z(resampled(spline, start, compared));
        // The second time what is left is found about the place itself.
        for (int round = 0; round < 2 && k > 0; ++round) {
            start += share_opposite(below, even) * spline.knots().back();
            even = seen_along_z(resampled(spline, start, compared));
        }
        below = std::move(even);
        profiles[k] = resampled(spline, start, count);
    }
    return profiles;
}

/// Of one number of points, point k of each at the same place: as they are, begun elsewhere, or by arc length.
std::vector<Profile> joined(std::vector<Profile> profiles) {
    const std::size_t n = profiles.front().size();
    if (std::any_of(profiles.begin(), profiles.end(), [n](const Profile& p) { return p.size() != n; })) {
        for (auto& profile : profiles)
            drop_repeats({&profile, 1});
        return from_the_sharpest(std::move(profiles));
    }
    drop_repeats(profiles);
    std::vector<std::vector<Eigen::Vector2d>> planes;
    std::transform(profiles.begin(), profiles.end(), std::back_inserter(planes), seen_along_z);
    const auto starts = profile_starts(planes);
    if (starts.all_at_first()) return profiles;
    if (!starts.points_agree) return from_opposite_places(std::move(profiles), starts.first);
    for (std::size_t k = 0; k < profiles.size(); ++k) {
        auto& profile = profiles[k];
        std::rotate(profile.begin(), profile.begin() + static_cast<std::ptrdiff_t>(starts.first[k]), profile.end());
    }
    return profiles;
}

/// Those of the loft at the nearest of its points.
void take_leans(const NominalContour& loft, NominalContour& plane) {
    plane.lean_rad = loft.lean_rad;
    plane.leans_rad.clear();
    for (const auto& point : plane.points) {
        const auto nearest = std::min_element(
            loft.points.begin(), loft.points.end(),
            [&](const auto& a, const auto& b) { return (a - point).squaredNorm() < (b - point).squaredNorm(); });
        plane.leans_rad.push_back(loft.leans_rad[static_cast<std::size_t>(nearest - loft.points.begin())]);
    }
}

class SectionsNominal final : public Nominal {
  public:
    /// Profiles counter-clockwise, ascending.
    explicit SectionsNominal(const std::vector<Profile>& profiles) {
        for (const auto& profile : profiles) {
            if (is_planar(profile)) planar_.push_back({centre_of(profile).z(), seen_along_z(profile), 0.0, {}});
        }
        if (profiles.size() > 1) loft_.emplace(joined(profiles));
        const bool ends_are_planar = is_planar(profiles.front()) && is_planar(profiles.back());
        // The loft of planar ends ends exactly in their planes; rounding must not cut them off.
        z_low_ = ends_are_planar ? planar_.front().z_mm : loft_->z_low_mm();
        z_high_ = ends_are_planar ? planar_.back().z_mm : loft_->z_high_mm();
        for (auto& plane : planar_) {
            if (loft_) take_leans(contour_from(plane.z_mm, loft_->cut(within(plane.z_mm))), plane);
        }
    }

    core::Result<NominalContour> cut(double z_mm) const override {
        if (auto status = require_height(z_mm, z_low_, z_high_); !status) return tl::unexpected(status.error());
        for (const auto& plane : planar_) {
            if (std::abs(plane.z_mm - z_mm) > same_plane_mm) continue;
            NominalContour contour = plane;
            contour.z_mm = z_mm;
            return contour;
        }
        return contour_from(z_mm, loft_->cut(within(z_mm)));
    }
    double z_low_mm() const override { return z_low_; }
    double z_high_mm() const override { return z_high_; }

  private:
    double within(double z_mm) const { return std::clamp(z_mm, loft_->z_low_mm(), loft_->z_high_mm()); }

    std::vector<NominalContour> planar_;  // ascending
    std::optional<Loft> loft_;
    double z_low_ = 0.0, z_high_ = 0.0;
};

core::Result<Profile> checked(const PointSection& section, Profile profile) {
    while (profile.size() > 1 && same_point(profile.front(), profile.back()))
        profile.pop_back();
    const double area = signed_area(seen_along_z(profile));
    const double length = perimeter(profile);
    if (profile.size() < least_points || std::abs(area) < 1e-6 * length * length) {
        return fail(ErrorCode::input_invalid,
                    "nominal section '" + section.name + "' is no closed contour seen along the span (" +
                        std::to_string(profile.size()) + " points, area " + core::fixed(std::abs(area), 6) + " mm2)");
    }
    // A gap wider than any step by far: the section was left open.
    const double gap = (profile.front() - profile.back()).norm();
    double widest = 0.0;
    for (std::size_t i = 0; i + 1 < profile.size(); ++i)
        widest = std::max(widest, (profile[i + 1] - profile[i]).norm());
    if (gap > 10.0 * widest) {
        return fail(ErrorCode::input_invalid, "nominal section '" + section.name + "' is open: " +
                                                  core::length_text(gap) + " between its last and first point");
    }
    if (area < 0.0) std::reverse(profile.begin(), profile.end());
    return profile;
}

}  // namespace

core::Result<std::shared_ptr<const Nominal>> sections_nominal(std::vector<PointSection> sections, Span span) {
    std::vector<Profile> raw;
    for (const auto& section : sections)
        raw.push_back(section.points_mm);
    if (span == Span::automatic) span = span_of(raw);
    std::vector<Profile> profiles;
    for (std::size_t k = 0; k < sections.size(); ++k) {
        for (auto& p : raw[k])
            p = turned_to_z(p, span);
        auto profile = checked(sections[k], std::move(raw[k]));
        if (!profile) return tl::unexpected(profile.error());
        profiles.push_back(std::move(*profile));
    }
    std::stable_sort(profiles.begin(), profiles.end(),
                     [](const Profile& a, const Profile& b) { return centre_of(a).z() < centre_of(b).z(); });
    if (profiles.size() == 1 && !is_planar(profiles.front())) {
        return fail(ErrorCode::input_invalid,
                    "one nominal section whose z is not constant cannot be cut: give at least two");
    }
    for (std::size_t k = 0; k + 1 < profiles.size(); ++k) {
        if (centre_of(profiles[k + 1]).z() - centre_of(profiles[k]).z() > same_plane_mm) continue;
        return fail(ErrorCode::input_invalid, "two nominal sections lie at the same height, z = " +
                                                  core::fixed(centre_of(profiles[k]).z(), 3) + " mm");
    }
    return std::make_shared<const SectionsNominal>(profiles);
}

}  // namespace cmm::acquisition
