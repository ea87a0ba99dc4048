// SPDX-License-Identifier: Apache-2.0
#include "fitting/best_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "fitting/chebyshev.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t enough_points = 400;  // least squares of a smooth contour: more tell nothing
constexpr std::size_t least_points = 12;
constexpr int most_fit_rounds = 60;
constexpr double still = 1e-7;         // mm, and rad times the section's size
constexpr double least_weight = 1e-9;  // of a direction against the best known one: below, it is not determined
constexpr double no_gain_mm = 1e-9;    // of the largest distance: where edges of its graph meet at a blunt angle, steps
                                       // go to and fro without end for less
constexpr double least_shorter = 1e-6;  // of a min-max step

/// Of the free numbers, three at most.
using FreeMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;
using FreeVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;

tl::unexpected<core::Error> cannot_fit(const char* why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, why);
}

std::string_view method_of(FitObjective objective) {
    switch (objective) {
        case FitObjective::least_squares:
            return "BESTFIT: least squares along the normals, weighted by arc length";
        case FitObjective::min_max:
            return "BESTFIT: the largest distance along the normals is smallest";
        case FitObjective::into_tolerance:
            return "BESTFIT: into the tolerance zones, the largest share of a zone is smallest";
    }
    return "BESTFIT";
}

Vec2 centre_of(const ClosedCurve& nominal) {
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

/// The free ones of shift x, shift y and turn.
std::vector<Eigen::Index> free_of(const BestFitOptions& options) {
    std::vector<Eigen::Index> free;
    if (options.translate_x) free.push_back(0);
    if (options.translate_y) free.push_back(1);
    if (options.rotate) free.push_back(2);
    return free;
}

class Fitter {
  public:
    Fitter(std::span<const FitMember> members, const BestFitOptions& options)
        : members_(members), options_(options), free_(free_of(options)) {
        double area = 0.0;
        for (const FitMember& member : members) {
            fit_.motion.about_mm += centre_of(*member.nominal) / static_cast<double>(members.size());
            area += std::abs(member.nominal->area()) / static_cast<double>(members.size());
        }
        size_mm_ = std::sqrt(area) + 1e-12;
        for (std::size_t m = 0; m < members.size(); ++m)
            choose(m);
        for (const Taken& taken : taken_)
            least_unit_ = std::min(least_unit_, unit_of(taken));
        fit_.slopes.resize(members.size());
    }

    core::Result<BestFit> run() {
        if (free_.empty()) return core::fail(core::ErrorCode::usage, "best fit: nothing may move");
        if (taken_.size() < least_points) return cannot_fit("best fit: too few points");
        find_feet();
        const bool squares = options_.objective == FitObjective::least_squares;
        bool sought_here = true;
        for (fit_.rounds = 1; fit_.rounds <= most_fit_rounds; ++fit_.rounds) {
            const auto moved = squares ? squares_step() : min_max_step();
            if (!moved) return tl::unexpected(moved.error());
            if (*moved >= still) {
                sought_here = false;
            } else if (!sought_here) {
                // Of a part that lay far off some feet began on the other side or beyond an edge, and stayed there.
                find_feet();
                sought_here = true;
            } else {
                describe();
                return std::move(fit_);
            }
        }
        return cannot_fit("best fit: no convergence");
    }

  private:
    struct Taken {
        std::size_t member, index;
        double width_mm;  // of contour that it stands for
        ToleranceZone zone;
        CurvePlace near;
        Eigen::Vector3d slopes;  // of its distance, by shift and turn; negative
        double off_mm;           // from the middle of its zone
        bool counts;
        Eigen::Vector3d weight;  // of it in the motion
    };

    void choose(std::size_t m) {
        const ContourGeometry& contour = *members_[m].contour;
        const auto& use = members_[m].use;
        const bool squares = options_.objective == FitObjective::least_squares;
        const std::size_t n = contour.size(), stride = squares ? std::max<std::size_t>(1, n / enough_points) : 1;
        for (std::size_t i = 0; i < n; i += stride) {
            const ContourPoint& p = contour.point(i);
            const auto zone = static_cast<std::size_t>(p.zone);
            if (!options_.zones[zone] || (!use.empty() && !use[i])) continue;
            const std::size_t before = i >= stride ? i - stride : i + n - stride - (n % stride);
            const double back = (p.position_mm - contour.point(before % n).position_mm).norm();
            const std::size_t after = i + stride < n ? i + stride : 0;
            const double ahead = (p.position_mm - contour.point(after).position_mm).norm();
            taken_.push_back({m,
                              i,
                              0.5 * (back + ahead),
                              options_.tolerance[zone],
                              {},
                              Eigen::Vector3d::Zero(),
                              0.0,
                              true,
                              Eigen::Vector3d::Zero()});
        }
    }

    /// The feet of all points at once; with them each round begins where the one before ended.
    void find_feet() {
        for (std::size_t first = 0; first < taken_.size();) {
            const FitMember& member = members_[taken_[first].member];
            std::size_t end = first;
            std::vector<Vec2> points;
            for (; end < taken_.size() && taken_[end].member == taken_[first].member; ++end)
                points.push_back(fit_.motion.undo(member.contour->point(taken_[end].index).position_mm));
            std::vector<ClosestPoint> feet(points.size());
            member.nominal->closest(points, feet);
            for (std::size_t k = 0; k < feet.size(); ++k)
                taken_[first + k].near = feet[k].place;
            first = end;
        }
    }

    /// Distances and slopes at the motion as it is.
    core::Status look() {
        double squares = 0.0, length = 0.0;
        std::size_t counted = 0;
        fit_.largest_mm = worst_ = 0.0;
        for (Taken& taken : taken_) {
            const ContourPoint& p = members_[taken.member].contour->point(taken.index);
            const ClosedCurve& nominal = *members_[taken.member].nominal;
            const ClosestPoint foot = nominal.closest(fit_.motion.undo(p.position_mm), taken.near);
            taken.near = foot.place;
            const Vec2 faces = foot.normal;
            taken.counts = faces.dot(fit_.motion.undo_on_direction(p.normal)) > 0.0;
            if (!taken.counts) continue;
            const Vec2 n = fit_.motion.apply_to_direction(faces);
            const Vec2 arm = left_of(p.position_mm - fit_.motion.about_mm - fit_.motion.shift_mm);
            // In units of the section's size, so that the matrix says how well each direction is known.
            taken.slopes = {n.x(), n.y(), n.dot(arm) / size_mm_};
            taken.off_mm = foot.distance_mm - taken.zone.middle_mm;
            squares += taken.width_mm * taken.off_mm * taken.off_mm;
            length += taken.width_mm;
            fit_.largest_mm = std::max(fit_.largest_mm, std::abs(taken.off_mm));
            worst_ = std::max(worst_, std::abs(taken.off_mm) / unit_of(taken));
            ++counted;
        }
        if (counted < least_points) return cannot_fit("best fit: the contour and the nominal do not lie on each other");
        fit_.rms_mm = std::sqrt(squares / length);
        return {};
    }

    double unit_of(const Taken& taken) const {
        return options_.objective == FitObjective::into_tolerance ? taken.zone.half_mm : 1.0;
    }

    /// Of the free numbers; says also how well they are known.
    core::Result<FreeMatrix> normal_matrix() {
        const auto d = static_cast<Eigen::Index>(free_.size());
        Eigen::Matrix3d full = Eigen::Matrix3d::Zero();
        for (const Taken& taken : taken_)
            if (taken.counts) full += taken.width_mm * taken.slopes * taken.slopes.transpose();
        FreeMatrix normal(d, d);
        for (Eigen::Index i = 0; i < d; ++i)
            for (Eigen::Index k = 0; k < d; ++k)
                normal(i, k) = full(free_[static_cast<std::size_t>(i)], free_[static_cast<std::size_t>(k)]);
        const auto values = Eigen::SelfAdjointEigenSolver<FreeMatrix>(normal, Eigen::EigenvaluesOnly).eigenvalues();
        // A single number is measured by what it could be at most: every point along its direction.
        const double best = std::max(values[d - 1], full.trace() / 3.0);
        if (!(values[0] > least_weight * best)) return cannot_fit("best fit: the points do not determine the motion");
        fit_.condition = std::sqrt(values[d - 1] / values[0]);
        return normal;
    }

    void move_by(const FreeVector& move) {
        for (std::size_t k = 0; k < free_.size(); ++k) {
            const double by = move[static_cast<Eigen::Index>(k)];
            if (free_[k] == 2)
                fit_.motion.turn_rad += by / size_mm_;
            else
                fit_.motion.shift_mm[free_[k]] += by;
        }
    }

    core::Result<double> squares_step() {
        if (auto status = look(); !status) return tl::unexpected(status.error());
        const auto normal = normal_matrix();
        if (!normal) return tl::unexpected(normal.error());
        const auto d = static_cast<Eigen::Index>(free_.size());
        const FreeMatrix inverse = normal->inverse();
        FreeVector move = FreeVector::Zero(d);
        for (Taken& taken : taken_) {
            if (!taken.counts) continue;
            FreeVector slopes(d);
            for (Eigen::Index k = 0; k < d; ++k)
                slopes[k] = taken.slopes[free_[static_cast<std::size_t>(k)]];
            const FreeVector weight = taken.width_mm * (inverse * slopes);
            move += taken.off_mm * weight;
            weigh(taken, weight);
        }
        move_by(move);
        return move.norm();
    }

    void weigh(Taken& taken, const FreeVector& weight) {
        taken.weight.setZero();
        for (std::size_t k = 0; k < free_.size(); ++k)
            taken.weight[free_[k]] = weight[static_cast<Eigen::Index>(k)] / (free_[k] == 2 ? size_mm_ : 1.0);
    }

    core::Result<double> min_max_step() {
        if (auto status = look(); !status) return tl::unexpected(status.error());
        if (const auto normal = normal_matrix(); !normal) return tl::unexpected(normal.error());
        const auto n = std::count_if(taken_.begin(), taken_.end(), [](const Taken& t) { return t.counts; });
        const auto d = static_cast<Eigen::Index>(free_.size());
        Eigen::MatrixXd rows(n, d);
        Eigen::VectorXd off(n);
        std::vector<Taken*> of_row;
        for (Taken& taken : taken_) {
            taken.weight.setZero();
            if (!taken.counts) continue;
            const auto row = static_cast<Eigen::Index>(of_row.size());
            for (Eigen::Index k = 0; k < d; ++k)
                rows(row, k) = taken.slopes[free_[static_cast<std::size_t>(k)]] / unit_of(taken);
            off[row] = taken.off_mm / unit_of(taken);
            of_row.push_back(&taken);
        }
        const auto best = chebyshev_fit(rows, off);
        if (!best) return tl::unexpected(best.error());
        for (std::size_t k = 0; k < best->active.size(); ++k) {
            Taken& taken = *of_row[best->active[k]];
            weigh(taken, best->by_active.col(static_cast<Eigen::Index>(k)) / unit_of(taken));
        }
        return shortened(best->x);
    }

    /// Goes along the step as far as it gets better; 0 where it does not.
    core::Result<double> shortened(const FreeVector& move) {
        const PlaneMotion from = fit_.motion;
        const double before = worst_;
        for (double share = 1.0; share > least_shorter; share *= 0.5) {
            fit_.motion = from;
            move_by(share * move);
            if (auto status = look(); !status) return tl::unexpected(status.error());
            if (worst_ < before - no_gain_mm / least_unit_) return share * move.norm();
        }
        fit_.motion = from;
        if (auto status = look(); !status) return tl::unexpected(status.error());
        return 0.0;
    }

    void describe() {
        for (const Taken& taken : taken_) {
            if (!taken.counts) continue;
            for (std::size_t k = 0; k < 3; ++k)
                if (const double weight = taken.weight[static_cast<Eigen::Index>(k)]; weight != 0.0)
                    fit_.slopes[taken.member][k].add(taken.index, weight);
        }
        if (options_.objective != FitObjective::least_squares) list_distances();
        const auto method = method_of(options_.objective);
        fit_.dx = {method, fit_.motion.shift_mm.x(), {}, {}};
        fit_.dy = {method, fit_.motion.shift_mm.y(), {}, {}};
        fit_.twist = {method, fit_.motion.turn_rad, {}, {}};
        if (members_.size() > 1) return;
        fit_.dx.slopes = fit_.slopes[0][0];
        fit_.dy.slopes = fit_.slopes[0][1];
        fit_.twist.slopes = fit_.slopes[0][2];
    }

    void list_distances() {
        for (const Taken& taken : taken_) {
            if (!taken.counts) continue;
            const double unit = unit_of(taken);
            FitDistance distance{taken.member, taken.index, taken.off_mm / unit, Eigen::Vector3d::Zero(), unit};
            for (const auto k : free_)
                distance.slopes[k] = taken.slopes[k] * (k == 2 ? size_mm_ : 1.0) / unit;
            fit_.distances.push_back(distance);
        }
    }

    std::span<const FitMember> members_;
    BestFitOptions options_;
    std::vector<Eigen::Index> free_;
    std::vector<Taken> taken_;
    double size_mm_ = 1.0;
    double least_unit_ = 1.0;
    double worst_ = 0.0;  // largest distance from a middle, in the unit of the objective
    BestFit fit_;
};

}  // namespace

std::string_view to_string(FitObjective objective) noexcept {
    switch (objective) {
        case FitObjective::least_squares:
            return "least_squares";
        case FitObjective::min_max:
            return "min_max";
        case FitObjective::into_tolerance:
            return "into_tolerance";
    }
    return "least_squares";
}

core::Result<BestFit> fit_to_nominals(std::span<const FitMember> members, const BestFitOptions& options) {
    return Fitter(members, options).run();
}

core::Result<BestFit> fit_to_nominal(const ContourGeometry& contour, const ClosedCurve& nominal,
                                     const BestFitOptions& options, std::span<const char> use) {
    const FitMember member{&contour, &nominal, use};
    return fit_to_nominals({&member, 1}, options);
}

}  // namespace cmm::fitting
