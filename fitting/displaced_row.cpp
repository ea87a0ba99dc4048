// SPDX-License-Identifier: Apache-2.0
#include "fitting/displaced_row.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "fitting/datum.hpp"
#include "fitting/small_system.hpp"

namespace cmm::fitting {
namespace {

constexpr int fit_rounds = 4;
constexpr double clear_sigmas = 1.0, least_clear_mm = 1e-3;  // rms distance of what lies apart
constexpr double left_share = 0.5;                           // of it, that a rigid motion leaves at most

}  // namespace

std::optional<PlaneMotion> displacement_of(const SmoothCurve& own, const ClosedCurve& level) {
    std::vector<Vec2> points;
    for (const auto& piece : own.curve.pieces())
        points.push_back(piece[0]);
    std::vector<ClosestPoint> feet(points.size());
    const auto rms = [&] {
        double squares = 0.0;
        for (const ClosestPoint& foot : feet)
            squares += foot.distance_mm * foot.distance_mm;
        return std::sqrt(squares / static_cast<double>(feet.size()));
    };
    level.closest(points, feet);
    const double apart = rms();
    if (apart < std::max(clear_sigmas * own.sigma_mm, least_clear_mm)) return std::nullopt;
    PlaneMotion motion{points.front()};
    for (int round = 0; round < fit_rounds; ++round) {
        SmallMatrix matrix = SmallMatrix::Zero(3, 3);
        SmallVector rhs = SmallVector::Zero(3);
        for (std::size_t k = 0; k < points.size(); ++k) {
            const Vec2 normal = motion.apply_to_direction(feet[k].normal);
            const Eigen::Vector3d slopes = answer_to_motion(motion, points[k], normal);
            matrix += slopes * slopes.transpose();
            rhs += feet[k].distance_mm * slopes;
        }
        const SmallVector step = solve_small(matrix, rhs);
        motion.shift_mm += step.head<2>();
        motion.turn_rad += step[2];
        std::vector<Vec2> laid;
        for (const Vec2& p : points)
            laid.push_back(motion.undo(p));
        level.closest(laid, feet);
    }
    return rms() < left_share * apart ? std::optional(motion) : std::nullopt;
}

PiecewiseCubic undone(const PiecewiseCubic& curve, const PlaneMotion& motion) {
    std::vector<PiecewiseCubic::Piece> pieces = curve.pieces();
    for (PiecewiseCubic::Piece& piece : pieces) {
        piece[0] = motion.undo(piece[0]);
        for (std::size_t j = 1; j < piece.size(); ++j)
            piece[j] = motion.undo_on_direction(piece[j]);
    }
    return {curve.breaks(), std::move(pieces), curve.closed()};
}

}  // namespace cmm::fitting
