// SPDX-License-Identifier: Apache-2.0
#include "fitting/datum.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "fitting/drawn_motion.hpp"

namespace cmm::fitting {
namespace {

MotionLoads loads_by(const MeasuredSection& section, const MotionSlopes& slopes) {
    MotionLoads loads = MotionLoads::Zero();
    const SectionFit& fit = section.fit();
    for (Eigen::Index k = 0; k < 3; ++k)
        loads.row(k) = fit.contour_noise.loads(fit.contour, slopes[static_cast<std::size_t>(k)]).transpose();
    return loads;
}

Eigen::Matrix3d covariance_by_places(const MeasuredSection& section, const MotionSlopes& slopes) {
    const SectionFit& fit = section.fit();
    Eigen::Matrix<double, 3, PlaceLoads::RowsAtCompileTime> loads;
    for (Eigen::Index k = 0; k < 3; ++k)
        loads.row(k) = fit.contour_noise.place_loads(fit.contour, slopes[static_cast<std::size_t>(k)]).transpose();
    return loads * loads.transpose();
}

/// Of the motion's three numbers by the points of one contour.
struct ByPoints {
    Eigen::Matrix3d noise = Eigen::Matrix3d::Zero(), standard = Eigen::Matrix3d::Zero();
};

ByPoints by_points(const MeasuredSection& section, const MotionSlopes& slopes) {
    const SectionFit& fit = section.fit();
    const auto variance = [&](const Sensitivity& number) { return fit.contour_noise.variance(fit.contour, number); };
    Eigen::Vector3d noise, standard;
    for (Eigen::Index k = 0; k < 3; ++k) {
        const auto& number = slopes[static_cast<std::size_t>(k)];
        noise[k] = std::sqrt(variance(number));
        standard[k] = fit.contour_noise.of(fit.contour, number).scatter;
    }
    Eigen::Matrix3d correlation = Eigen::Matrix3d::Identity();
    for (Eigen::Index i = 0; i < 3; ++i) {
        for (Eigen::Index k = 0; k < i; ++k) {
            if (!(noise[i] > 0.0 && noise[k] > 0.0)) continue;
            // Var(a/sa + b/sb) = 2 + 2 rho.
            Sensitivity sum;
            sum.add(slopes[static_cast<std::size_t>(i)], 1.0 / noise[i]);
            sum.add(slopes[static_cast<std::size_t>(k)], 1.0 / noise[k]);
            correlation(i, k) = correlation(k, i) = std::clamp(0.5 * variance(sum) - 1.0, -1.0, 1.0);
        }
    }
    return {noise.asDiagonal() * correlation * noise.asDiagonal(),
            standard.asDiagonal() * correlation * standard.asDiagonal()};
}

/// What is positive of a symmetric matrix.
Eigen::Matrix3d positive_part(const Eigen::Matrix3d& m) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(m);
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace

Measure Datum::of_aligned(Measure measure, const ContourGeometry& aligned) const {
    // By the aligned contour moved as one body, in the directions of the measured frame.
    Eigen::Vector3d by_motion = Eigen::Vector3d::Zero();
    for (const auto& [point, weight] : measure.slopes.parts()) {
        const ContourPoint& p = aligned.point(point);
        const Vec2 faces = motion.apply_to_direction(p.normal);
        by_motion -=
            weight * Eigen::Vector3d(faces.x(), faces.y(), p.normal.dot(left_of(p.position_mm - motion.about_mm)));
    }
    for (Eigen::Index k = 0; k < 3; ++k)
        measure.slopes.add(slopes[static_cast<std::size_t>(k)], by_motion[k]);
    measure.beside.variance += std::max(0.0, by_motion.dot(from_others * by_motion));
    measure.beside.loads += loads_of_others.transpose() * by_motion;
    return measure;
}

Eigen::Vector3d answer_to_motion(const PlaneMotion& motion, const Vec2& position_mm, const Vec2& normal) {
    return {normal.x(), normal.y(), normal.dot(left_of(position_mm - motion.about_mm - motion.shift_mm))};
}

double normal_uncertainty(const PlaneMotion& motion, const Eigen::Matrix3d& covariance, const Vec2& position_mm,
                          const Vec2& normal) {
    const Eigen::Vector3d slopes = answer_to_motion(motion, position_mm, normal);
    return std::sqrt(std::max(0.0, slopes.dot(covariance * slopes)));
}

void set_place_errors(std::vector<ContourPoint>& contour, const ContourNoise& noise, const Datum* datum) {
    for (ContourPoint& point : contour) {
        FieldLoads loads = noise.loads_at(point);
        if (datum != nullptr)
            loads -= datum->loads.transpose() * answer_to_motion(datum->motion, point.position_mm, point.normal);
        for (std::size_t k = 0; k < error_sources; ++k)
            point.machine.standard_mm[k] = std::sqrt(variance_of(loads, static_cast<ErrorSource>(k)));
        double& length = point.machine.standard_mm[static_cast<std::size_t>(ErrorSource::length)];
        length = std::hypot(length, noise.place_mm(point));
        point.machine.known_mm = known_of(loads);
    }
}

std::vector<Datum> datums_of(const BestFit& fit, std::span<const MeasuredSection* const> sections) {
    const auto drawn = draw_motions(fit, sections);
    const auto& slopes = drawn ? drawn->slopes : fit.slopes;
    std::vector<Datum> datums(sections.size());
    Eigen::Matrix3d all = Eigen::Matrix3d::Zero(), places = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d curved = drawn ? drawn->covariance : Eigen::Matrix3d::Zero();
    MotionLoads loads = MotionLoads::Zero();
    for (std::size_t m = 0; m < sections.size(); ++m) {
        Datum& datum = datums[m];
        datum.motion = fit.motion;
        datum.slopes = slopes[m];
        // What is its own goes from the sums.
        const ByPoints own = by_points(*sections[m], slopes[m]);
        datum.from_others = own.standard;
        curved -= own.noise;
        if (sections[m]->fit().contour_noise.has_fields()) {
            const Eigen::Matrix3d own_places = covariance_by_places(*sections[m], slopes[m]);
            datum.from_others += own_places;
            places += own_places;
            datum.loads_of_others = loads_by(*sections[m], slopes[m]);
        }
        all += datum.from_others;
        loads += datum.loads_of_others;
    }
    // What no slopes say belongs to no contour.
    if (drawn) all += positive_part(curved);
    for (Datum& datum : datums) {
        datum.from_others = (all - datum.from_others).eval();
        datum.covariance = all;
        datum.places = places;
        datum.loads_of_others = (loads - datum.loads_of_others).eval();
        datum.loads = loads;
    }
    return datums;
}

SectionFit undone(SectionFit fit, const PlaneMotion& motion) {
    for (ContourPoint& point : fit.contour) {
        point.position_mm = motion.undo(point.position_mm);
        point.normal = motion.undo_on_direction(point.normal);
    }
    fit.le_point_mm = motion.undo(fit.le_point_mm);
    fit.te_point_mm = motion.undo(fit.te_point_mm);
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() << std::cos(motion.turn_rad), std::sin(motion.turn_rad), -std::sin(motion.turn_rad),
        std::cos(motion.turn_rad);
    for (EdgeFit* edge : {&fit.le, &fit.te}) {
        edge->centre_mm = motion.undo(edge->centre_mm);
        edge->covariance_mm2 = (turn * edge->covariance_mm2 * turn.transpose()).eval();
    }
    fit.contour_noise.lies_in(motion);
    return fit;
}

}  // namespace cmm::fitting
