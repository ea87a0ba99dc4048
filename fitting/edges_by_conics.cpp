// SPDX-License-Identifier: Apache-2.0
#include "fitting/edges_by_conics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "fitting/edge_conic.hpp"
#include "fitting/edges.hpp"

namespace cmm::fitting {
namespace {

// Shares of an edge's length.
constexpr double seen_joint_reach = 0.5;  // from where the curvature falls to the joint of the curve that shows the end
constexpr double inwards_share = 0.1;     // of an end without joint: so far inwards it surely is the edge
constexpr double beyond_share = 0.15;     // of a joint: there the side is taken ...
constexpr double far_beyond_share = 0.3;  // ... and there of an end without joint, ...
constexpr double farthest_beyond = 0.7;   // ... and farther, up to there, while that is the edge still
constexpr double rate_share = 0.6;        // over which its curvature changes
constexpr double next_share = 0.06;       // ... and at last
constexpr double least_beyond = 0.02;     // of the joint that is found
constexpr double farthest_end_share = 0.5;  // from the end that was seen to the joint
constexpr double noise_share = 0.02;        // over which the curve's slope is taken for its uncertainty
constexpr double told_reach = 0.3;          // of a joint, for the curve
constexpr double least_step_per_mm = 0.02;  // of the curvature: less is no end
constexpr int most_windows = 4, most_joint_steps = 12;
constexpr double longest_newton_step_mm = 0.2, last_newton_step_mm = 1e-6;
constexpr int samples_per_span = 4;

/// Parameters where an edge ends by the curve, unwrapped; whether there is a joint.
struct SeenEnd {
    double t = 0.0;
    bool joint = false;
};
using SeenEnds = std::array<SeenEnd, 2>;

/// The ends of both edges; none where there are no two edges.
std::vector<SeenEnds> ends_of_edges(const SmoothCurve& smooth) {
    const PiecewiseCubic& curve = smooth.curve;
    std::vector<OffsetPoint> contour;
    for (std::size_t span = 0; span < curve.spans(); ++span) {
        const double from = curve.breaks()[span], step = (curve.breaks()[span + 1] - from) / samples_per_span;
        for (int k = 0; k < samples_per_span; ++k) {
            const Jet jet = curve.jet_in(span, from + k * step);
            contour.push_back({jet.position, jet.right_normal(), from + k * step});
        }
    }
    std::vector<SeenEnds> ends;
    const auto edges = find_edges(contour, {}, {});
    if (!edges) return ends;
    for (const EdgeRegion& region : {edges->le, edges->te}) {
        const double begin = contour[region.begin].t, wrapped = contour[region.end].t;
        const double end = wrapped > begin ? wrapped : wrapped + curve.period();
        SeenEnds seen{SeenEnd{begin}, SeenEnd{end}};
        for (const bool ending : {false, true}) {
            SeenEnd& its = seen[ending ? 1 : 0];
            double nearest = seen_joint_reach * (end - begin);
            const double falls = its.t;
            for (const CurvatureStep& joint : smooth.joints) {
                const double off = std::remainder(joint.t - falls, curve.period());
                if ((joint.step < 0.0) != ending || std::abs(off) > nearest) continue;
                nearest = std::abs(off);
                its = {falls + off, true};
            }
        }
        if (seen[0].t < seen[1].t) ends.push_back(seen);
    }
    return ends;
}

/// The points around one edge in order, with their parameters unwrapped.
struct PointsAround {
    EdgePoints edge;
    std::vector<double> t, curvature;  // of the part

    PointsAround(const SmoothCurve& smooth, std::span<const Vec2> points, std::span<const std::size_t> order,
                 double ball_mm, double from, double to) {
        const PiecewiseCubic& curve = smooth.curve;
        edge.ball_mm = ball_mm;
        edge.noise = {smooth.sigma_mm, static_cast<double>(points.size()) - smooth.freedom};
        const double begin = curve.wrap(from);
        const auto first = std::lower_bound(order.begin(), order.end(), begin,
                                            [&](std::size_t i, double t_of) { return smooth.parameter[i] < t_of; });
        auto at = static_cast<std::size_t>(first - order.begin());
        for (std::size_t k = 0; k < order.size(); ++k, ++at) {
            const std::size_t i = order[at % order.size()];
            const double lap = at < order.size() ? 0.0 : curve.period();
            const double unwrapped = from + (smooth.parameter[i] + lap - begin);
            if (unwrapped > to) break;
            double inside = smooth.parameter[i];
            const std::size_t span = curve.span_of(inside);
            const Jet jet = curve.jet_in(span, inside);
            edge.points.push_back({points[i], jet.right_normal(), smooth.residual[i], smooth.leverage[i]});
            curvature.push_back(jet.curvature() / (1.0 - ball_mm * jet.curvature()));
            t.push_back(unwrapped);
        }
        edge.nose = between(from, 0.5 * (from + to)).end;
        edge.nose = edge.nose > 0 ? edge.nose - 1 : 0;
    }

    EdgeWindow between(double from, double to) const {
        const auto position = [&](double value) {
            return static_cast<std::size_t>(std::lower_bound(t.begin(), t.end(), value) - t.begin());
        };
        return {position(from), position(to)};
    }
};

/// Finds the joints of one edge.
class EdgeJoints {
  public:
    EdgeJoints(const SmoothCurve& smooth, std::span<const Vec2> points, std::span<const std::size_t> order,
               double ball_mm, const SeenEnds& seen)
        : curve_(smooth.curve),
          noise_(smooth.noise),
          seen_(seen),
          length_(seen[1].t - seen[0].t),
          around_(smooth, points, order, ball_mm, seen[0].t - farthest_end_share * length_,
                  seen[1].t + farthest_end_share * length_),
          fitter_(around_.edge, around_.curvature) {
        for (std::size_t end = 0; end < 2; ++end)
            joints_[end].t = seen[end].t - (seen[end].joint ? 0.0 : inwards_share * length_ * outwards(end));
    }

    /// The conic tells the joints, between which its points are. False when there is no such conic.
    bool run() {
        EdgeWindow last;
        for (int round = 0; round < most_windows; ++round) {
            const EdgeWindow window = around_.between(joints_[0].t, joints_[1].t);
            if (conic_ && window == last) return true;
            conic_ = fitter_.fit(window);
            if (!conic_ || !place(*conic_, 0) || !place(*conic_, 1)) return false;
            last = window;
        }
        return true;
    }
    ToldEdge told() const {
        ToldEdge edge{joints_[0], joints_[1],
                      [curve = &curve_, conic = *conic_, ball_mm = around_.edge.ball_mm](double t) {
                          const Jet jet = curve->jet(curve->wrap(t));
                          const Vec2 normal = conic.normal(jet.position, jet.right_normal());
                          return 1.0 / (conic.radius_mm(normal) + ball_mm);
                      }};
        for (ToldJoint* joint : {&edge.begin, &edge.end})
            joint->t = curve_.wrap(joint->t);
        return edge;
    }

  private:
    static double outwards(std::size_t end) { return end == 0 ? -1.0 : 1.0; }

    /// First from where it surely is the side, then from next to what that tells.
    bool place(const EdgeConic& conic, std::size_t end) {
        const SeenEnd& seen = seen_[end];
        bool placed = false;
        for (double beyond = seen.joint ? beyond_share : far_beyond_share; !placed && beyond < farthest_beyond;
             beyond += beyond_share)
            placed = place(conic, end, seen.t + outwards(end) * beyond * length_);
        if (!placed) return false;
        const ToldJoint first = joints_[end];
        const double outermost = outwards(end) * std::max(outwards(end) * seen.t, outwards(end) * first.t);
        const double next = seen.joint ? next_share : beyond_share;
        if (!place(conic, end, outermost + outwards(end) * next * length_)) joints_[end] = first;
        return true;
    }

    /// Where the side, as it goes on from `side_t` with its curvature and the change of that, has the normal of the
    /// conic: by Newton's method, both turning as they do.
    bool place(const EdgeConic& conic, std::size_t end, double side_t) {
        const Jet side = curve_.jet(curve_.wrap(side_t));
        const double curvature = side.curvature(), speed = side.d1.norm();
        const double away = outwards(end) * rate_share * length_;
        const double rate = (curve_.jet(curve_.wrap(side_t + away)).curvature() - curvature) / away;
        const Vec2 tangent = side.d1 / speed, normal = side.right_normal();
        double along = 0.0, step = 0.0, move = longest_newton_step_mm;
        Vec2 at = side.position, own = normal;
        for (int k = 0; k < most_joint_steps && std::abs(move) > last_newton_step_mm; ++k) {
            const Vec2 its = conic.normal(at, own);
            step = 1.0 / (conic.radius_mm(its) + around_.edge.ball_mm) - curvature - rate * along;
            move = std::clamp(-turn_angle(own, its) / step, -longest_newton_step_mm, longest_newton_step_mm);
            along += move;
            if (!(std::abs(along) < 2.0 * length_)) return false;
            const double angle = (curvature + 0.5 * rate * along) * along;
            at = side.position + along * tangent - (0.5 * curvature + rate * along / 6.0) * along * along * normal;
            own = std::cos(angle) * normal + std::sin(angle) * tangent;
        }
        ToldJoint& joint = joints_[end];
        joint.t = side_t + along / speed;
        joint.sigma_mm = std::sqrt(conic.direction_variance(at, own) + direction_variance(side_t, along)) / step;
        joint.step = -outwards(end) * step;
        joint.reach_mm = told_reach * length_;
        return step > least_step_per_mm && -outwards(end) * along > least_beyond * length_ &&
               std::abs(joint.t - seen_[end].t) < farthest_end_share * length_;
    }

    /// Of the side so far from a place: by the curve's slope and curvature there.
    double direction_variance(double t, double along) const {
        const double h = noise_share * length_, of_slope = 0.5 / h, of_curvature = along / (h * h);
        std::vector<double> slopes(noise_.controls(), 0.0);
        CurveNoise::Walk walk(noise_);
        walk.add_place(curve_.wrap(t - h), of_curvature - of_slope, slopes);
        walk.add_place(curve_.wrap(t), -2.0 * of_curvature, slopes);
        walk.add_place(curve_.wrap(t + h), of_curvature + of_slope, slopes);
        return noise_.variance(slopes).sum();
    }

    const PiecewiseCubic& curve_;
    const CurveNoise& noise_;
    SeenEnds seen_;
    double length_;
    PointsAround around_;
    ConicFitter fitter_;
    std::array<ToldJoint, 2> joints_;
    std::optional<EdgeConic> conic_;
};

}  // namespace

std::vector<ToldEdge> edges_by_conics(const SmoothCurve& smooth, std::span<const Vec2> points, double ball_mm) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto before = [&](std::size_t a, std::size_t b) { return smooth.parameter[a] < smooth.parameter[b]; };
    if (!std::is_sorted(order.begin(), order.end(), before)) std::stable_sort(order.begin(), order.end(), before);
    std::vector<ToldEdge> told;
    for (const SeenEnds& seen : ends_of_edges(smooth)) {
        EdgeJoints edge(smooth, points, order, ball_mm, seen);
        if (edge.run()) told.push_back(edge.told());
    }
    return told;
}

}  // namespace cmm::fitting
