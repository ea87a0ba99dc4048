// SPDX-License-Identifier: Apache-2.0
#include "fitting/best_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr std::size_t enough_points = 600;  // the contour is smooth: more tell nothing
constexpr std::size_t least_points = 12;
constexpr int most_rounds = 60;
constexpr double still = 1e-10;        // mm, and rad times the section's size
constexpr double least_weight = 1e-9;  // of a direction against the best known one: below, it is not determined

tl::unexpected<core::Error> cannot_fit(const char* why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, why);
}

Vec2 turned(const Vec2& v, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

class Fitter {
  public:
    Fitter(const ContourGeometry& contour, const ClosedCurve& nominal, const BestFitOptions& options,
           std::span<const char> use)
        : contour_(contour), nominal_(nominal), options_(options) {
        fit_.about_mm = centre_of(nominal);
        size_mm_ = std::sqrt(std::abs(nominal.area())) + 1e-12;
        choose(use);
    }

    core::Result<BestFit> run() {
        if (taken_.size() < least_points) return cannot_fit("best fit: too few points");
        if (!options_.translate && !options_.rotate) return cannot_fit("best fit: nothing may move");
        for (fit_.rounds = 1; fit_.rounds <= most_rounds; ++fit_.rounds) {
            if (auto status = step(); !status) return tl::unexpected(status.error());
            if (last_move_ < still) {
                describe();
                return fit_;
            }
        }
        return cannot_fit("best fit: no convergence");
    }

  private:
    struct Taken {
        std::size_t index;
        double width_mm;  // of contour that it stands for
        std::optional<double> near_mm;
        Eigen::Vector3d slopes;  // of its distance, by shift and turn; negative
        bool counts;
    };

    static Vec2 centre_of(const ClosedCurve& nominal) {
        const std::size_t n = 400;
        std::vector<Vec2> p;
        for (std::size_t k = 0; k < n; ++k)
            p.push_back(nominal.position(nominal.length() * static_cast<double>(k) / static_cast<double>(n)));
        double area = 0.0;
        Vec2 first = Vec2::Zero();
        for (std::size_t k = 0; k < n; ++k) {
            const Vec2 a = p[k] - p[0], b = p[(k + 1) % n] - p[0];
            area += cross(a, b);
            first += cross(a, b) * (a + b);
        }
        return p[0] + first / (3.0 * area);
    }

    void choose(std::span<const char> use) {
        const std::size_t n = contour_.size(), stride = std::max<std::size_t>(1, n / enough_points);
        for (std::size_t i = 0; i < n; i += stride) {
            const ContourPoint& p = contour_.point(i);
            if (!options_.zones[static_cast<std::size_t>(p.zone)] || (!use.empty() && !use[i])) continue;
            const std::size_t before = i >= stride ? i - stride : i + n - stride - (n % stride);
            const double back = (p.position_mm - contour_.point(before % n).position_mm).norm();
            const std::size_t after = i + stride < n ? i + stride : 0;
            const double ahead = (p.position_mm - contour_.point(after).position_mm).norm();
            taken_.push_back({i, 0.5 * (back + ahead), {}, Eigen::Vector3d::Zero(), true});
        }
    }

    core::Status step() {
        Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
        Eigen::Vector3d moment = Eigen::Vector3d::Zero();
        double squares = 0.0, length = 0.0;
        std::size_t counted = 0;
        for (Taken& taken : taken_) {
            const ContourPoint& p = contour_.point(taken.index);
            const Vec2 q = fit_.in_nominal(p.position_mm);
            const ClosestPoint foot = nominal_.closest(q, taken.near_mm);
            taken.near_mm = foot.s_mm;
            const Vec2 faces = nominal_.evaluate(foot.s_mm).normal;
            taken.counts = faces.dot(fit_.direction_in_nominal(p.normal)) > 0.0;
            if (!taken.counts) continue;
            const Vec2 n = turned(faces, fit_.twist_rad);
            const Vec2 arm = left_of(p.position_mm - fit_.about_mm - fit_.shift_mm);
            // In units of the section's size, so that the matrix says how well each direction is known.
            taken.slopes = {options_.translate ? n.x() : 0.0, options_.translate ? n.y() : 0.0,
                            options_.rotate ? n.dot(arm) / size_mm_ : 0.0};
            normal += taken.width_mm * taken.slopes * taken.slopes.transpose();
            moment += taken.width_mm * foot.distance_mm * taken.slopes;
            squares += taken.width_mm * foot.distance_mm * foot.distance_mm;
            length += taken.width_mm;
            ++counted;
        }
        if (counted < least_points) return cannot_fit("best fit: the contour and the nominal do not lie on each other");
        if (!options_.translate) normal(0, 0) = normal(1, 1) = length;
        if (!options_.rotate) normal(2, 2) = length;
        const auto values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(normal).eigenvalues();
        if (!(values[0] > least_weight * values[2]))
            return cannot_fit("best fit: the points do not determine the motion");
        inverse_ = normal.inverse();
        const Eigen::Vector3d move = inverse_ * moment;
        fit_.shift_mm += move.head<2>();
        fit_.twist_rad += move[2] / size_mm_;
        fit_.rms_mm = std::sqrt(squares / length);
        last_move_ = move.norm();
        return {};
    }

    void describe() {
        fit_.dx = {"BESTFIT: least squares along the normals, weighted by arc length", fit_.shift_mm.x(), {}, 0.0};
        fit_.dy = {"BESTFIT: least squares along the normals, weighted by arc length", fit_.shift_mm.y(), {}, 0.0};
        fit_.twist = {"BESTFIT: least squares along the normals, weighted by arc length", fit_.twist_rad, {}, 0.0};
        for (const Taken& taken : taken_) {
            if (!taken.counts) continue;
            const Eigen::Vector3d by = taken.width_mm * (inverse_ * taken.slopes);
            fit_.dx.slopes.add(taken.index, by[0]);
            fit_.dy.slopes.add(taken.index, by[1]);
            fit_.twist.slopes.add(taken.index, by[2] / size_mm_);
        }
    }

    const ContourGeometry& contour_;
    const ClosedCurve& nominal_;
    BestFitOptions options_;
    std::vector<Taken> taken_;
    double size_mm_ = 1.0, last_move_ = 0.0;
    Eigen::Matrix3d inverse_ = Eigen::Matrix3d::Identity();
    BestFit fit_;
};

}  // namespace

Vec2 BestFit::in_nominal(const Vec2& p) const {
    return turned(p - about_mm - shift_mm, -twist_rad) + about_mm;
}

Vec2 BestFit::direction_in_nominal(const Vec2& v) const {
    return turned(v, -twist_rad);
}

core::Result<BestFit> fit_to_nominal(const ContourGeometry& contour, const ClosedCurve& nominal,
                                     const BestFitOptions& options, std::span<const char> use) {
    return Fitter(contour, nominal, options, use).run();
}

}  // namespace cmm::fitting
