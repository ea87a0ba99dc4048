// SPDX-License-Identifier: Apache-2.0
#include "fitting/corners.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Dense>

#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t chord_points = 3;  // of the coarse search
constexpr double coarse_sure = 8.0;      // standard deviations of a direction
constexpr std::size_t gaps_apart = 5;    // gaps whose chords do not cross the one examined
constexpr std::size_t most_side = 12, least_side = 5;
constexpr std::size_t most_bad = 2;        // of a side
constexpr double flank_floor_mm = 0.5e-3;  // what an arc leaves of a smooth flank
constexpr double significant = 8.0;        // standard deviations of the angle
constexpr double rounded = 1.0;            // standard deviations that a curve without corner rounds off: turn x gap / 8
constexpr double sudden = 1.5;             // times what a flank turns in a gap
constexpr double better = 30.0;            // by which the squares over sigma^2 fall: e^15 in likelihood
constexpr double price = 10.0;             // of a point that is not explained, in squares over sigma^2
constexpr double not_worse = 8.0;          // the same close to the corner, where a fillet shows
constexpr double clear_rad = 0.7;          // no polynomial follows such a turn

/// y = a0 + a1 x + a2 x^2 + a2^3 x^4 over a side: a circle's arc to the fourth order, x in half lengths of the side
/// from its middle, 1 at its nearest point to the corner.
struct FlankBranch {
    std::array<Vec2, most_side> used;
    std::size_t count = 0;
    Vec2 origin = Vec2::Zero(), along = Vec2::UnitX();
    double scale = 1.0;
    Eigen::Vector3d a = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // for sigma 1
    double squares = 0.0;

    Vec2 left() const { return {-along.y(), along.x()}; }
    double quartic() const { return a[2] * a[2] * a[2] / (scale * scale); }
    double height(double x) const { return a[0] + x * (a[1] + x * (a[2] + x * x * quartic())); }
    double slope(double x) const { return (a[1] + x * (2.0 * a[2] + 4.0 * x * x * quartic())) / scale; }
    Vec2 at(double x) const { return origin + scale * x * along + height(x) * left(); }
    Vec2 derivative(double x) const { return scale * (along + slope(x) * left()); }
    double curvature() const { return 2.0 * a[2] / (scale * scale); }
    double slope_variance(double x) const {
        const Eigen::Vector3d row(0.0, 1.0 / scale, 2.0 * x / scale);
        return row.dot(covariance * row);
    }
    double off_squared(const Vec2& p) const {
        const Vec2 d = p - origin;
        const double x = d.dot(along) / scale, s = slope(x), off = cross(along, d) - height(x);
        return off * off / (1.0 + s * s);
    }

    Eigen::Vector3d row_at(const Vec2& p) const {
        const double x = (p - origin).dot(along) / scale;
        return {1.0, x, x * x};
    }

    void fit() {
        const Vec2 side = used[0] - used[count - 1];
        scale = 0.5 * side.norm();
        along = side.normalized();
        origin = 0.5 * (used[0] + used[count - 1]);
        a.setZero();
        for (int pass = 0; pass < 2; ++pass) {
            Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
            Eigen::Vector3d rhs = Eigen::Vector3d::Zero();
            for (std::size_t i = 0; i < count; ++i) {
                const Eigen::Vector3d row = row_at(used[i]);
                normal.noalias() += row * row.transpose();
                rhs += (cross(along, used[i] - origin) - quartic() * row[2] * row[2]) * row;
            }
            covariance = normal.inverse();
            a = covariance * rhs;
        }
        squares = 0.0;
        for (std::size_t i = 0; i < count; ++i)
            squares += off_squared(used[i]);
    }

    /// By how much the squares fall without point i.
    double blame(std::size_t i) const {
        const Eigen::Vector3d row = row_at(used[i]);
        return off_squared(used[i]) / std::max(1.0 - row.dot(covariance * row), 1e-3);
    }

    void leave_out(std::size_t i) {
        std::copy(used.begin() + i + 1, used.begin() + count, used.begin() + i);
        --count;
        fit();
    }
};

class CornerSearch {
  public:
    CornerSearch(std::span<const Vec2> points, double sigma)
        : points_(points), n_(points.size()), sigma_(std::max(sigma, flank_floor_mm)) {}

    std::vector<CurveCorner> run() {
        const std::vector<char> candidate = gaps_that_turn();
        // A bad point near a corner may hide its gap from the chords, but not the next one, too.
        for (std::size_t i = 0; i < n_; ++i)
            if (candidate[i] || candidate[(i + 1) % n_] || candidate[(i + n_ - 1) % n_]) judge(i);
        if (found_.size() > 1 && rival(found_.front(), found_.back()))
            found_.erase(found_.front().cost <= found_.back().cost ? found_.end() - 1 : found_.begin());
        std::vector<CurveCorner> corners;
        for (const Found& f : found_)
            corners.push_back(f.corner);
        return corners;
    }

  private:
    struct Found {
        CurveCorner corner;
        double cost = 0.0;  // squares over sigma^2, and the price of points that a branch does not reach or leaves out
    };

    const Vec2& point(std::size_t i) const { return points_[i % n_]; }

    /// Gap i lies between the points i and i + 1: right turns of the chords on either side of it that neither the noise
    /// nor the curvature nearby explains.
    std::vector<char> gaps_that_turn() const {
        std::vector<double> turn(n_), curvature(n_), noise(n_);
        for (std::size_t i = 0; i < n_; ++i) {
            const Vec2 in = point(i + n_) - point(i + n_ - chord_points);
            const Vec2 out = point(i + 1 + chord_points) - point(i + 1);
            const double across = -cross(in, out), along = in.dot(out);
            turn[i] = across < 0.1 * along ? across / along : std::atan2(across, along);
            const double shorter = std::sqrt(std::min(in.squaredNorm(), out.squaredNorm()));
            curvature[i] = turn[i] / (0.5 * (in + out).norm() + (point(i + 1) - point(i)).norm());
            noise[i] = sigma_ / shorter;
        }
        std::vector<char> candidate(n_, 0);
        for (std::size_t i = 0; i < n_; ++i) {
            const double nearby = 0.5 * (curvature[(i + gaps_apart) % n_] + curvature[(i + n_ - gaps_apart) % n_]);
            const double length = curvature[i] != 0.0 ? turn[i] / curvature[i] : 0.0;
            candidate[i] = turn[i] - nearby * length > coarse_sure * noise[i] ? 1 : 0;
        }
        return candidate;
    }

    void judge(std::size_t gap) {
        const auto arriving = side(gap, false), leaving = side(gap + 1, true);
        if (!arriving || !leaving) return;
        double x = 1.0, y = 1.0;  // on either branch
        for (int step = 0; step < 8; ++step) {
            const Vec2 apart_by = leaving->at(y) - arriving->at(x);
            const Vec2 u = arriving->derivative(x), v = leaving->derivative(y);
            const double across = cross(u, v);
            if (std::abs(across) < 1e-12 * arriving->scale * leaving->scale) return;
            x += std::clamp(cross(apart_by, v) / across, -1.0, 1.0);
            y += std::clamp(cross(apart_by, u) / across, -1.0, 1.0);
        }
        const double width = (point(gap + 1) - point(gap)).norm();
        CurveCorner corner;
        corner.before = gap;
        corner.after = (gap + 1) % n_;
        corner.position = arriving->at(x);
        corner.arriving = arriving->derivative(x).normalized();
        corner.leaving = -leaving->derivative(y).normalized();
        corner.turn_rad = -turn_angle(corner.arriving, corner.leaving);
        corner.turn_sigma_rad = sigma_ * std::sqrt(arriving->slope_variance(x) + leaving->slope_variance(y));
        if (corner.turn_rad < significant * corner.turn_sigma_rad) return;
        const double flanks = std::max(std::abs(arriving->curvature()), std::abs(leaving->curvature()));
        if (corner.turn_rad * width < 8.0 * rounded * sigma_ || corner.turn_rad < sudden * flanks * width) return;
        const double slack = 3.0 * sigma_ / std::sin(std::min(corner.turn_rad, 1.5));
        const double farthest = width / std::max(std::cos(0.5 * corner.turn_rad), 0.1) + slack;
        const double legs[2] = {(x - 1.0) * arriving->scale, (y - 1.0) * leaving->scale};
        if (std::min(legs[0], legs[1]) < -slack || std::max(legs[0], legs[1]) > farthest) return;
        if (corner.turn_rad < clear_rad && (over_quintic(corner, *arriving, *leaving, most_side) < better ||
                                            over_quintic(corner, *arriving, *leaving, least_side) < -not_worse))
            return;
        const double unused = static_cast<double>(2 * most_side - arriving->count - leaving->count);
        keep({corner, (arriving->squares + leaving->squares) / (sigma_ * sigma_) + price * unused});
    }

    /// Of corners in neighbouring gaps the one that explains its points best.
    void keep(const Found& found) {
        if (found_.empty() || !rival(found_.back(), found)) {
            found_.push_back(found);
        } else if (found.cost < found_.back().cost) {
            found_.back() = found;
        }
    }

    bool rival(const Found& a, const Found& b) const {
        const std::size_t gaps = (b.corner.before + n_ - a.corner.before) % n_;
        return std::min(gaps, n_ - gaps) <= chord_points;
    }

    /// The points from `nearest` on, away from the gap; as many as a parabola explains.
    std::optional<FlankBranch> side(std::size_t nearest, bool forwards) const {
        for (std::size_t count = most_side; count >= least_side; count -= 2) {
            FlankBranch branch;
            branch.count = count;
            for (std::size_t k = 0; k < count; ++k)
                branch.used[k] = point(forwards ? nearest + k : nearest + n_ - k);
            branch.fit();
            if (explains(branch)) return branch;
            for (std::size_t bad = count >= 10 ? most_bad : count >= 7 ? 1 : 0; bad > 0; --bad) {
                leave_worst_out(branch);
                if (explains(branch)) return branch;
            }
        }
        return {};
    }

    bool explains(const FlankBranch& branch) const {
        constexpr double rare = 3.1;
        return branch.squares <= sigma_ * sigma_ * chi_square_limit(static_cast<double>(branch.count - 3), rare);
    }

    /// But neither the nearest (on a fillet it is no bad point) nor the farthest two (where those are off the side is
    /// too long).
    static void leave_worst_out(FlankBranch& branch) {
        std::size_t worst = 1;
        for (std::size_t i = 2; i + 2 < branch.count; ++i)
            if (branch.blame(i) > branch.blame(worst)) worst = i;
        branch.leave_out(worst);
    }

    /// By how much one quintic through the nearest `most` points of either side fits worse than the two branches.
    double over_quintic(const CurveCorner& corner, const FlankBranch& arriving, const FlankBranch& leaving,
                        std::size_t most) const {
        using Row = Eigen::Matrix<double, 6, 1>;
        const Vec2 along = (corner.arriving + corner.leaving).normalized();
        const double scale = std::max(arriving.scale, leaving.scale);
        Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
        Row rhs = Row::Zero();
        const auto row_at = [](double x) {
            Row row;
            row << 1.0, x, x * x, x * x * x, x * x * x * x, x * x * x * x * x;
            return row;
        };
        const auto each = [&](const auto& take) {
            for (const FlankBranch* side : {&arriving, &leaving})
                for (std::size_t i = 0; i < std::min(most, side->count); ++i) {
                    const Vec2 d = side->used[i] - corner.position;
                    take(d.dot(along) / scale, cross(along, d));
                }
        };
        each([&](double x, double y) {
            const Row row = row_at(x);
            normal.noalias() += row * row.transpose();
            rhs += y * row;
        });
        const Row a = normal.ldlt().solve(rhs);
        double squares = 0.0;
        each([&](double x, double y) {
            const double slope =
                (a[1] + x * (2.0 * a[2] + x * (3.0 * a[3] + x * (4.0 * a[4] + x * 5.0 * a[5])))) / scale;
            const double off = y - a.dot(row_at(x));
            squares += off * off / (1.0 + slope * slope);
        });
        for (const FlankBranch* side : {&arriving, &leaving})
            for (std::size_t i = 0; i < std::min(most, side->count); ++i)
                squares -= side->off_squared(side->used[i]);
        return squares / (sigma_ * sigma_);
    }

    std::span<const Vec2> points_;
    std::size_t n_;
    double sigma_;
    std::vector<Found> found_;
};

}  // namespace

std::vector<CurveCorner> find_corners(std::span<const Vec2> points, double sigma_mm) {
    if (points.size() < 4 * most_side) return {};
    return CornerSearch(points, sigma_mm).run();
}

}  // namespace cmm::fitting
