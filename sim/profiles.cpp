// SPDX-License-Identifier: Apache-2.0
#include "sim/profiles.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace cmm::sim {

namespace {

constexpr double same_point_mm = 1e-4;

double signed_area(const Points& loop) {
    double twice = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const auto &a = loop[i], &b = loop[(i + 1) % loop.size()];
        twice += (a.x() - loop[0].x()) * (b.y() - loop[0].y()) - (b.x() - loop[0].x()) * (a.y() - loop[0].y());
    }
    return 0.5 * twice;
}

void drop_point(std::vector<Points>& profiles, std::size_t i) {
    for (auto& profile : profiles)
        profile.erase(profile.begin() + static_cast<std::ptrdiff_t>(i));
}

/// Leaves out a point that repeats the one before it in every one of the profiles.
void drop_repeats(std::vector<Points>& profiles) {
    for (std::size_t i = profiles.front().size(); i-- > 0 && profiles.front().size() > least_profile_points;) {
        const std::size_t n = profiles.front().size(), before = (i + n - 1) % n;
        if (std::all_of(profiles.begin(), profiles.end(),
                        [&](const Points& p) { return (p[i] - p[before]).norm() < same_point_mm; })) {
            drop_point(profiles, i);
        }
    }
}

/// One over the radius of the circle through a point and its neighbours.
double curvature(const Points& p, std::size_t i) {
    const std::size_t n = p.size();
    const Eigen::Vector3d a = p[(i + n - 1) % n] - p[i], b = p[(i + 1) % n] - p[i];
    const double product = a.norm() * b.norm() * (a - b).norm();
    return product > 0.0 ? 2.0 * a.cross(b).norm() / product : 0.0;
}

double perimeter(const Points& p) {
    double sum = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i)
        sum += (p[(i + 1) % p.size()] - p[i]).norm();
    return sum;
}

/// The point of largest curvature; with a neighbour's start given, only about there: the other edge may be as sharp.
std::size_t sharpest(const Points& p, const Points* neighbour, std::size_t neighbour_start) {
    std::size_t best = p.size();
    const Eigen::Vector3d centre = mean_of(p);
    const Eigen::Vector3d about =
        neighbour == nullptr ? centre : Eigen::Vector3d(centre + (*neighbour)[neighbour_start] - mean_of(*neighbour));
    const double reach = perimeter(p) / 4.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        if (neighbour != nullptr && (p[i] - about).norm() > reach) continue;
        if (best == p.size() || curvature(p, i) > curvature(p, best)) best = i;
    }
    return best == p.size() ? sharpest(p, nullptr, 0) : best;
}

/// A profile as a curve with its arc length, from one of its points on.
class ProfileCurve {
  public:
    ProfileCurve(Points points, std::size_t start) : points_(std::move(points)) {
        std::rotate(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(start), points_.end());
        knots_.push_back(0.0);
        for (std::size_t i = 0; i < points_.size(); ++i) {
            knots_.push_back(knots_.back() + (points_[(i + 1) % points_.size()] - points_[i]).norm());
        }
        moments_ = periodic_moments(knots_, points_);
        measure();
    }
    double length() const { return lengths_.back(); }
    double length_at_knot(std::size_t i) const { return lengths_[i * steps]; }
    std::size_t size() const { return points_.size(); }

    Eigen::Vector3d at_length(double s) const {
        const std::size_t i = spline_interval(lengths_, s);
        const double part = (s - lengths_[i]) / (lengths_[i + 1] - lengths_[i]);
        return at(std::lerp(parameter(i), parameter(i + 1), part));
    }

  private:
    static constexpr std::size_t steps = 16;  // per interval; the length is only used to place points on the curve

    double parameter(std::size_t i) const {
        const std::size_t k = std::min(i / steps, points_.size() - 1);
        return std::lerp(knots_[k], knots_[k + 1], static_cast<double>(i - k * steps) / steps);
    }
    Eigen::Vector3d at(double u) const {
        const std::size_t i = spline_interval(knots_, u), next = (i + 1) % points_.size();
        const auto b = spline_basis(knots_[i], knots_[i + 1], u).f;
        return b[0] * points_[i] + b[1] * points_[next] + b[2] * moments_[i] + b[3] * moments_[next];
    }
    void measure() {
        lengths_.push_back(0.0);
        Eigen::Vector3d before = points_.front();
        for (std::size_t i = 1; i <= steps * points_.size(); ++i) {
            const Eigen::Vector3d here = at(parameter(i));
            lengths_.push_back(lengths_.back() + (here - before).norm());
            before = here;
        }
    }

    Points points_, moments_;
    std::vector<double> knots_, lengths_;
};

/// Arc-length fractions of all curves' points in one rising list, without those that nearly coincide.
std::vector<double> common_fractions(const std::vector<ProfileCurve>& curves) {
    constexpr double least_gap = 5e-4;
    std::vector<double> all, kept;
    for (const auto& curve : curves) {
        for (std::size_t i = 0; i < curve.size(); ++i)
            all.push_back(curve.length_at_knot(i) / curve.length());
    }
    std::sort(all.begin(), all.end());
    for (const double fraction : all) {
        if ((kept.empty() || fraction - kept.back() > least_gap) && fraction < 1.0 - least_gap)
            kept.push_back(fraction);
    }
    return kept;
}

/// A profile about its mean, seen along the span.
std::vector<Eigen::Vector2d> about_mean(const Points& profile) {
    const Eigen::Vector3d mean = mean_of(profile);
    std::vector<Eigen::Vector2d> out;
    for (const auto& point : profile)
        out.emplace_back((point - mean).head<2>());
    return out;
}

/// What b misses of being a, turned (by less than a right angle) and scaled, when b begins with its point `first`: 0
/// to 1.
double unlikeness(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b, std::size_t first) {
    const std::size_t step = a.size() / 300 + 1;
    double along = 0.0, across = 0.0, square_a = 0.0, square_b = 0.0;
    for (std::size_t i = 0; i < a.size(); i += step) {
        const auto &p = a[i], &q = b[(i + first) % b.size()];
        along += p.dot(q);
        across += p.x() * q.y() - p.y() * q.x();
        square_a += p.squaredNorm();
        square_b += q.squaredNorm();
    }
    return 1.0 - (along > 0.0 ? along * along + across * across : across * across) / (square_a * square_b);
}

/// Profiles of one number of points may begin at different places: each is begun where it fits the one below it best.
void begin_together(std::vector<Points>& profiles) {
    constexpr double much_better = 0.5;  // profiles of different forms miss something, too
    constexpr double nothing_missed = 1e-7;
    for (std::size_t k = 0; k + 1 < profiles.size(); ++k) {
        const auto a = about_mean(profiles[k]), b = about_mean(profiles[k + 1]);
        double least = much_better * unlikeness(a, b, 0);
        if (least < nothing_missed) continue;
        std::size_t best = 0;
        for (std::size_t first = 1; first < b.size(); ++first) {
            const double missed = unlikeness(a, b, first);
            if (missed >= least) continue;
            least = missed;
            best = first;
        }
        auto& above = profiles[k + 1];
        std::rotate(above.begin(), above.begin() + static_cast<std::ptrdiff_t>(best), above.end());
    }
}

std::vector<Points> resampled(const std::vector<Points>& profiles) {
    std::vector<ProfileCurve> curves;
    std::size_t start = 0;
    for (std::size_t k = 0; k < profiles.size(); ++k) {
        start = sharpest(profiles[k], k == 0 ? nullptr : &profiles[k - 1], start);
        curves.emplace_back(profiles[k], start);
    }
    std::vector<Points> result(profiles.size());
    for (const double fraction : common_fractions(curves)) {
        for (std::size_t k = 0; k < curves.size(); ++k) {
            result[k].push_back(curves[k].at_length(fraction * curves[k].length()));
        }
    }
    return result;
}

}  // namespace

Eigen::Vector3d mean_of(const Points& points) {
    return std::accumulate(points.begin(), points.end(), Eigen::Vector3d(Eigen::Vector3d::Zero())) /
           static_cast<double>(points.size());
}

std::vector<Points> joined_profiles(std::vector<Points> profiles) {
    std::stable_sort(profiles.begin(), profiles.end(),
                     [](const Points& a, const Points& b) { return mean_of(a).z() < mean_of(b).z(); });
    for (auto& profile : profiles) {
        if (signed_area(profile) < 0.0) std::reverse(profile.begin() + 1, profile.end());
    }
    const bool same_number = std::all_of(profiles.begin(), profiles.end(),
                                         [&](const Points& p) { return p.size() == profiles.front().size(); });
    if (same_number) {
        begin_together(profiles);
        drop_repeats(profiles);
        return profiles;
    }
    for (auto& profile : profiles) {
        std::vector<Points> one{std::move(profile)};
        drop_repeats(one);
        profile = std::move(one.front());
    }
    return resampled(profiles);
}

}  // namespace cmm::sim
