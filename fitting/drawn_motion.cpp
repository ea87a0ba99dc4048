// SPDX-License-Identifier: Apache-2.0
#include "fitting/drawn_motion.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/rng.hpp"
#include "fitting/chebyshev.hpp"

namespace cmm::fitting {
namespace {

constexpr int draws = 100;                // tell a standard deviation to 7 %
constexpr double steepest = 3.0;          // slopes by which a motion errs so many times as it does say nothing of it
constexpr double lacking_sigmas = 10.0;   // standard uncertainties: what lacks more does not become the largest
constexpr std::size_t most_places = 160;  // of a section: its noise has some hundred free numbers
constexpr double own_noise = 1e-8;        // of a place, over the largest variance
constexpr std::uint64_t seed = 0xD4A3;

/// Of one section: the distances that may become the largest, and what their errors do together.
struct Candidates {
    std::vector<const FitDistance*> distances;
    Eigen::MatrixXd covariance;  ///< mm^2
    Eigen::MatrixXd root;        ///< of it: times independent standard numbers
};

double standard_mm(const FitDistance& distance, const MeasuredSection& section) {
    return section.contour().point(distance.point).u95_mm / section.fit().contour_noise.coverage();
}

bool rests_on(const MotionSlopes& slopes, std::size_t point) {
    return std::any_of(slopes.begin(), slopes.end(), [&](const Sensitivity& number) {
        return std::any_of(number.parts().begin(), number.parts().end(),
                           [&](const auto& part) { return part.first == point; });
    });
}

/// A root of a covariance that is singular to rounding: but for a little noise of each place by itself, elimination
/// divides by what rounding has left.
Eigen::MatrixXd root_of(Eigen::MatrixXd covariance) {
    covariance.diagonal().array() += own_noise * covariance.diagonal().maxCoeff();
    return covariance.llt().matrixL();
}

std::vector<Candidates> candidates_of(const BestFit& fit, std::span<const MeasuredSection* const> sections) {
    const auto in_unit = [&](const FitDistance& d) { return standard_mm(d, *sections[d.member]) / d.unit_mm; };
    double largest = 0.0, of_largest = 0.0;
    for (const FitDistance& d : fit.distances) {
        largest = std::max(largest, std::abs(d.off));
        if (rests_on(fit.slopes[d.member], d.point)) of_largest = std::max(of_largest, in_unit(d));
    }
    std::vector<Candidates> out(sections.size());
    for (const FitDistance& d : fit.distances)
        if (std::abs(d.off) + 0.5 * lacking_sigmas * (in_unit(d) + of_largest) >= largest)
            out[d.member].distances.push_back(&d);
    for (std::size_t m = 0; m < out.size(); ++m) {
        auto& taken = out[m].distances;
        const std::size_t stride = (taken.size() + most_places - 1) / most_places;
        std::size_t count = 0;
        std::erase_if(
            taken, [&](const FitDistance* d) { return count++ % stride != 0 && !rests_on(fit.slopes[m], d->point); });
        std::vector<std::size_t> places;
        for (const FitDistance* d : taken)
            places.push_back(d->point);
        if (places.empty()) continue;
        const SectionFit& section = sections[m]->fit();
        out[m].covariance = section.contour_noise.covariance(section.contour, places);
        out[m].root = root_of(out[m].covariance);
    }
    return out;
}

/// The min-max problem at the motion found, by the distances that matter.
struct Problem {
    std::vector<Candidates> of_member;
    std::vector<Eigen::Index> free;  ///< numbers of the motion that may move
    Eigen::MatrixXd rows;            ///< places x free
    Eigen::VectorXd off;

    Problem(const BestFit& fit, std::span<const MeasuredSection* const> sections)
        : of_member(candidates_of(fit, sections)) {
        std::vector<const FitDistance*> all;
        for (const Candidates& member : of_member)
            all.insert(all.end(), member.distances.begin(), member.distances.end());
        for (Eigen::Index k = 0; k < 3; ++k)
            if (std::any_of(all.begin(), all.end(), [&](const FitDistance* d) { return d->slopes[k] != 0.0; }))
                free.push_back(k);
        rows.resize(static_cast<Eigen::Index>(all.size()), static_cast<Eigen::Index>(free.size()));
        off.resize(rows.rows());
        for (Eigen::Index i = 0; i < rows.rows(); ++i) {
            const FitDistance& d = *all[static_cast<std::size_t>(i)];
            off[i] = d.off;
            for (Eigen::Index k = 0; k < rows.cols(); ++k)
                rows(i, k) = d.slopes[free[static_cast<std::size_t>(k)]];
        }
    }

    Eigen::VectorXd drawn(core::Rng& rng) const {
        Eigen::VectorXd out = off;
        Eigen::Index first = 0;
        for (const Candidates& member : of_member) {
            Eigen::VectorXd independent(static_cast<Eigen::Index>(member.distances.size()));
            for (double& number : independent)
                number = rng.normal();
            const Eigen::VectorXd errors_mm = member.root * independent;
            for (Eigen::Index i = 0; i < errors_mm.size(); ++i)
                out[first + i] += errors_mm[i] / member.distances[static_cast<std::size_t>(i)]->unit_mm;
            first += errors_mm.size();
        }
        return out;
    }
};

/// How the free numbers of one draw's motion answer to the four places that it rests on.
struct Slopes {
    std::vector<std::size_t> rows;
    Eigen::MatrixXd by_row;
};

class Answers {
  public:
    explicit Answers(const Problem& problem) : problem_(problem) {
        for (std::size_t m = 0; m < problem.of_member.size(); ++m)
            for (std::size_t k = 0; k < problem.of_member[m].distances.size(); ++k)
                places_.push_back({m, k});
    }

    /// Of each free number, mm^2 or rad^2.
    Eigen::VectorXd variance(const Slopes& slopes) const {
        Eigen::VectorXd out = Eigen::VectorXd::Zero(slopes.by_row.rows());
        for (std::size_t i = 0; i < slopes.rows.size(); ++i)
            for (std::size_t k = 0; k < slopes.rows.size(); ++k)
                out += covariance(slopes.rows[i], slopes.rows[k]) *
                       slopes.by_row.col(static_cast<Eigen::Index>(i))
                           .cwiseProduct(slopes.by_row.col(static_cast<Eigen::Index>(k)));
        return out;
    }

    void add(const Slopes& slopes, double factor, std::vector<MotionSlopes>& out) const {
        for (std::size_t i = 0; i < slopes.rows.size(); ++i) {
            const Place& place = places_[slopes.rows[i]];
            const FitDistance& distance = distance_of(place);
            for (std::size_t k = 0; k < problem_.free.size(); ++k)
                out[place.member][static_cast<std::size_t>(problem_.free[k])].add(
                    distance.point, factor * slopes.by_row(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(i)) /
                                        distance.unit_mm);
        }
    }

  private:
    struct Place {
        std::size_t member, at;
    };
    const FitDistance& distance_of(const Place& place) const {
        return *problem_.of_member[place.member].distances[place.at];
    }
    double covariance(std::size_t one, std::size_t other) const {
        const Place &a = places_[one], &b = places_[other];
        if (a.member != b.member) return 0.0;
        return problem_.of_member[a.member].covariance(static_cast<Eigen::Index>(a.at),
                                                       static_cast<Eigen::Index>(b.at)) /
               (distance_of(a).unit_mm * distance_of(b).unit_mm);
    }

    const Problem& problem_;
    std::vector<Place> places_;  ///< by row
};

}  // namespace

std::optional<DrawnMotion> draw_motions(const BestFit& fit, std::span<const MeasuredSection* const> sections) {
    if (fit.distances.empty()) return std::nullopt;
    const Problem problem(fit, sections);
    core::Rng rng(seed);
    DrawnMotion out{std::vector<MotionSlopes>(sections.size()), Eigen::Matrix3d::Zero()};
    std::vector<Slopes> slopes;
    for (int draw = 0; draw < draws; ++draw) {
        auto found = chebyshev_fit(problem.rows, problem.drawn(rng));
        if (!found) return std::nullopt;
        Eigen::Vector3d motion = Eigen::Vector3d::Zero();
        for (std::size_t k = 0; k < problem.free.size(); ++k)
            motion[problem.free[k]] = found->x[static_cast<Eigen::Index>(k)];
        out.covariance += motion * motion.transpose() / draws;
        slopes.push_back({std::move(found->active), std::move(found->by_active)});
    }
    const Answers answers(problem);
    std::erase_if(slopes, [&](const Slopes& of_draw) {
        const Eigen::VectorXd variance = answers.variance(of_draw);
        for (std::size_t k = 0; k < problem.free.size(); ++k)
            if (variance[static_cast<Eigen::Index>(k)] >
                steepest * steepest * out.covariance(problem.free[k], problem.free[k]))
                return true;
        return false;
    });
    for (const Slopes& of_draw : slopes)
        answers.add(of_draw, 1.0 / static_cast<double>(slopes.size()), out.slopes);
    return out;
}

}  // namespace cmm::fitting
