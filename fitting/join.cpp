// SPDX-License-Identifier: Apache-2.0
#include "fitting/join.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace cmm::fitting {
namespace {

constexpr std::size_t pieces_in_model = 40;
constexpr std::array<std::size_t, 3> bridged_points{6, 9, 13};
constexpr std::size_t searched_points = 10;  // for the joint, beyond the last one that the model explains
constexpr std::size_t points_inside = 6;     // of the model, before its last one
constexpr double inside_handicap = 12.0;     // chi-square: the free form always rounds a joint somewhat
constexpr double swing_share = 0.5;          // of the step of the curvature at the joint
constexpr double bridge_floor_mm = 1e-4;     // what a bridge may be off by itself
constexpr double least_search_step = 0.05;   // in points
// Dense at the joint, where the curvature jumps.
constexpr std::array bridge_shares{0.003, 0.01, 0.025, 0.05, 0.1, 0.2, 0.35, 0.55, 0.75};
constexpr std::array model_shares{0.0, 0.001, 0.003, 0.007,
                                  0.014};  // of the model from either end, beside the even ones

/// The place on the model's curve of ball centres nearest to p, and the outward normal there.
struct Centre {
    Vec2 position, normal;
    double curvature;
};
Centre centre_on(const EdgeShape& shape, double ball_mm, const Vec2& p, const Vec2& near) {
    return std::visit(
        [&](const auto& s) -> Centre {
            if constexpr (std::is_same_v<std::decay_t<decltype(s)>, std::monostate>) {
                return {p, near, 0.0};
            } else {
                const auto foot = s.foot(p, near);
                return {foot.position + ball_mm * foot.normal, foot.normal, 1.0 / (s.radius_at(foot.normal) + ball_mm)};
            }
        },
        shape);
}

double value(const std::array<double, 5>& y, double u) {
    return u * u * (y[0] + u * (y[1] + u * (y[2] + u * (y[3] + u * y[4]))));
}

/// One side of an edge: its points are counted away from the nose, from some that the model explains on.
class BridgeBuilder {
  public:
    BridgeBuilder(const PiecewiseCubic& curve, const EdgePoints& edge, std::span<const double> t,
                  const ModelTrial& trial, bool after)
        : curve_(curve),
          after_(after),
          variance_(std::pow(std::max(edge.noise.sigma_mm, bridge_floor_mm), 2)),
          price_(std::log(static_cast<double>(edge.points.size()))) {
        const std::size_t n = edge.points.size(), inside = std::min(points_inside, trial.end - trial.begin);
        const std::size_t begin = after ? trial.end - inside : n - trial.begin - inside;
        for (std::size_t k = begin; k < std::min(n, begin + inside + searched_points + bridged_points.back()); ++k) {
            const std::size_t i = after ? k : n - 1 - k;
            const EdgePoint& p = edge.points[i];
            const Centre centre = centre_on(trial.shape, edge.ball_mm, p.centre, p.normal);
            const double off_model = (p.centre - centre.position).dot(centre.normal);
            const double free = p.residual_mm * p.residual_mm / variance_ + p.leverage * price_;
            points_.push_back({p.centre, t[i], centre, off_model * off_model / variance_, free});
        }
        inside_ = inside;
    }

    std::optional<Bridge> run() {
        // Where the free form needs no help, it takes over inside the model.
        if (inside_ >= 3) attempt(0.0, inside_ - 1, false);
        const std::optional<Bridge> inside = best_;
        const double least_inside = least_;
        least_ = std::numeric_limits<double>::infinity();
        for (std::size_t k = inside_ - std::min<std::size_t>(inside_, 2); k < inside_ + searched_points; ++k)
            attempt(static_cast<double>(k), k + bridged_points[1], true);
        for (const std::size_t length : bridged_points)
            for (double step = 0.5; step > least_search_step; step *= 0.5) {
                const double middle = where_;
                for (const double at : {middle - step, middle + step})
                    if (at >= 0.0) attempt(at, static_cast<std::size_t>(at) + length, true);
            }
        return least_ < least_inside + inside_handicap ? best_ : inside;
    }

  private:
    struct Point {
        Vec2 p;
        double t;
        Centre model;
        double model_cost, free_cost;  // chi-square, and for the free form its share of the price
    };

    /// The bridge from the model beside a place between two points to the free form at a further point.
    void attempt(double at, std::size_t far, bool turn) {
        const auto k = static_cast<std::size_t>(at);
        const double share = at - std::floor(at);
        if (far >= points_.size() || far < k + 3) return;
        const Vec2 normal =
            ((1.0 - share) * points_[k].model.normal + share * points_[k + 1].model.normal).normalized();
        Bridge bridge;
        bridge.joint = on_model(k, share, normal);
        bridge.outward = normal;
        bridge.along = after_ ? left_of(normal) : Vec2(-left_of(normal));
        bridge.t_joint = (1.0 - share) * points_[k].t + share * points_[k + 1].t;
        bridge.t_free = points_[far].t;
        if (!reach_free_form(bridge)) return;
        if (turn) turn_to_points(bridge, k, far);
        if (turn && !bends_evenly(bridge, points_[k].model.curvature)) return;
        double cost = turn ? 3.0 * price_ : 0.0;
        for (std::size_t i = 0; i < points_.size(); ++i)
            cost += i <= k ? points_[i].model_cost : i < far ? cost_on(bridge, points_[i]) : points_[i].free_cost;
        if (cost >= least_) return;
        least_ = cost;
        where_ = at;
        best_ = bridge;
    }

    /// Between the feet of two neighbours: along their cubic, whose error is below a nanometre.
    Vec2 on_model(std::size_t k, double share, const Vec2& normal) const {
        const Centre &a = points_[k].model, &b = points_[k + 1].model;
        const Vec2 chord = b.position - a.position;
        const double bulge = 0.5 * share * (1.0 - share) * chord.norm() * std::abs(cross(a.normal, b.normal));
        return a.position + share * chord + bulge * normal;
    }

    /// Position, slope and curvature of the free form at the far end; nothing yet at the joint.
    bool reach_free_form(Bridge& bridge) const {
        const Jet jet = curve_.jet(bridge.t_free);
        const Vec2 off = jet.position - bridge.joint;
        const double dx = jet.d1.dot(bridge.along), dy = jet.d1.dot(bridge.outward);
        const double length = off.dot(bridge.along);
        if (!(length > 0.0) || std::abs(dy) > std::abs(dx)) return false;
        const double slope = dy / dx;
        const double bend = (jet.d2.dot(bridge.outward) - slope * jet.d2.dot(bridge.along)) / (dx * dx);
        const double a = off.dot(bridge.outward), b = slope * length, c = bend * length * length;
        bridge.length_mm = length;
        bridge.y = {0.0, 10.0 * a - 4.0 * b + 0.5 * c, -15.0 * a + 7.0 * b - c, 6.0 * a - 3.0 * b + 0.5 * c, 0.0};
        return true;
    }

    /// Adds multiples of u^2 (1-u)^3 and u^3 (1-u)^3, which change nothing at the far end and no tangent at the joint.
    void turn_to_points(Bridge& bridge, std::size_t k, std::size_t far) const {
        double qq = 0.0, qr = 0.0, rr = 0.0, qe = 0.0, re = 0.0;
        for (std::size_t i = k + 1; i < far; ++i) {
            const Vec2 off = points_[i].p - bridge.joint;
            const double u = off.dot(bridge.along) / bridge.length_mm;
            const double v = 1.0 - u, q = u * u * v * v * v, r = u * q;
            const double e = off.dot(bridge.outward) - value(bridge.y, u);
            qq += q * q;
            qr += q * r;
            rr += r * r;
            qe += q * e;
            re += r * e;
        }
        const double determinant = qq * rr - qr * qr;
        if (!(determinant > 1e-9 * qq * rr)) return;
        const double f = (rr * qe - qr * re) / determinant, g = (qq * re - qr * qe) / determinant;
        bridge.y[0] += f;
        bridge.y[1] += g - 3.0 * f;
        bridge.y[2] += 3.0 * f - 3.0 * g;
        bridge.y[3] += 3.0 * g - f;
        bridge.y[4] -= g;
    }

    /// Its curvature stays near those of the model and of the free form: points that are still bad make it swing.
    static bool bends_evenly(const Bridge& bridge, double model_curvature) {
        const auto bend_at = [&](double u) {
            double sum = 0.0, power = 1.0;
            for (std::size_t k = 0; k < bridge.y.size(); ++k, power *= u)
                sum += static_cast<double>((k + 2) * (k + 1)) * bridge.y[k] * power;
            return sum / (bridge.length_mm * bridge.length_mm);
        };
        const double far = bend_at(1.0), margin = swing_share * std::abs(far + model_curvature);
        const double low = std::min(far, -model_curvature) - margin, high = std::max(far, -model_curvature) + margin;
        for (double u = 0.0; u < 0.95; u += 0.1)
            if (const double bend = bend_at(u); bend < low || bend > high) return false;
        return true;
    }

    double cost_on(const Bridge& bridge, const Point& point) const {
        const Vec2 off = point.p - bridge.joint;
        const double u = off.dot(bridge.along) / bridge.length_mm;
        const double e = off.dot(bridge.outward) - value(bridge.y, u);
        return e * e / variance_;
    }

    const PiecewiseCubic& curve_;
    bool after_;
    double variance_, price_;
    std::vector<Point> points_;
    std::size_t inside_ = 0;
    std::optional<Bridge> best_;
    double least_ = std::numeric_limits<double>::infinity(), where_ = 0.0;
};

}  // namespace

Vec2 Bridge::place(const Vec2& p) const {
    const double u = (p - joint).dot(along) / length_mm;
    return joint + u * length_mm * along + value(y, u) * outward;
}

std::optional<EdgePatch::Dependence> EdgePatch::dependence(double t, double period, const Vec2& part_point,
                                                           const Vec2& normal) const {
    t += period * std::ceil((before.t_free - t) / period);
    if (t > after.t_free) return {};
    const bool on_before = t < before.t_joint, on_model = !on_before && t <= after.t_joint;
    const Bridge& bridge = on_before ? before : after;
    const Vec2 near = on_model ? normal : bridge.outward;
    const Vec2 at = on_model ? part_point : Vec2(bridge.joint - ball_mm * bridge.outward);
    Dependence out;
    std::visit(
        [&](const auto& s) {
            if constexpr (std::is_same_v<std::decay_t<decltype(s)>, std::monostate>) {
                out.on_free = 1.0;
            } else {
                out.on_model = s.foot(at, near).slopes;
            }
        },
        shape);
    if (on_model || out.on_free > 0.0) return out;
    const double u = std::clamp((t - bridge.t_joint) / (bridge.t_free - bridge.t_joint), 0.0, 1.0);
    const double own = 4.0 * u * (1.0 - u);  // the bridge's two parameters and the place of the joint: as the free form
    out.on_model *= std::sqrt(1.0 - u);
    out.on_free = std::sqrt(u + own);
    return out;
}

std::optional<double> EdgePatch::sigma_mm(double t, double period, const Vec2& part_point, const Vec2& normal,
                                          double free_mm) const {
    const auto on = dependence(t, period, part_point, normal);
    if (!on) return {};
    double variance = std::pow(on->on_free * free_mm, 2);
    if (on->on_model.size() > 0) variance += std::max(0.0, on->on_model.dot(covariance * on->on_model));
    return std::sqrt(variance);
}

std::vector<EdgePatch::Place> EdgePatch::places(const PiecewiseCubic& curve) const {
    std::vector<Place> places;
    for (const Bridge* bridge : {&before, &after}) {
        for (const double share : bridge_shares) {
            const double t = bridge->t_joint + share * (bridge->t_free - bridge->t_joint);
            places.push_back({t, bridge->place(curve.jet(t).position)});
        }
        places.push_back({bridge->t_free, curve.jet(bridge->t_free).position});
    }
    const auto add_on_model = [&](double share) {
        const double t = before.t_joint + share * (after.t_joint - before.t_joint);
        const Jet jet = curve.jet(t);
        places.push_back({t, centre_on(shape, ball_mm, jet.position, jet.right_normal()).position});
    };
    for (std::size_t k = 1; k < pieces_in_model; ++k)
        add_on_model(static_cast<double>(k) / pieces_in_model);
    for (const double share : model_shares) {
        add_on_model(share);
        add_on_model(1.0 - share);
    }
    return places;
}

std::optional<EdgePatch> make_patch(const PiecewiseCubic& curve, const EdgePoints& edge, std::span<const double> t,
                                    const ModelTrial& trial) {
    const auto before = BridgeBuilder(curve, edge, t, trial, false).run();
    const auto after = BridgeBuilder(curve, edge, t, trial, true).run();
    if (!before || !after) return {};
    return EdgePatch{trial.shape, edge.ball_mm, trial.covariance, *before, *after};
}

PiecewiseCubic join_edges(const PiecewiseCubic& curve, std::span<const EdgePatch> patches) {
    if (patches.empty()) return curve;
    const double period = curve.period();
    std::vector<EdgePatch::Place> knots;
    for (std::size_t k = 0; k + 1 < curve.breaks().size(); ++k) {
        const double t = curve.breaks()[k];
        const bool replaced = std::any_of(patches.begin(), patches.end(), [&](const EdgePatch& patch) {
            const double first = patch.before.t_free;
            return t + period * std::ceil((first - t) / period) <= patch.after.t_free;
        });
        if (!replaced) knots.push_back({t, curve.pieces()[k][0]});
    }
    for (const EdgePatch& patch : patches)
        for (const EdgePatch::Place& place : patch.places(curve))
            knots.push_back({curve.wrap(place.t), place.position});
    std::sort(knots.begin(), knots.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
    // Breaks closer than this would only make the interpolation worse; the loss is below a nanometre.
    const double least = 1e-5 * period;
    knots.erase(
        std::unique(knots.begin(), knots.end(), [&](const auto& a, const auto& b) { return b.t - a.t < least; }),
        knots.end());
    while (knots.size() > 3 && knots.front().t + period - knots.back().t < least)
        knots.pop_back();
    std::vector<Vec2> points;
    std::vector<double> at;
    for (const EdgePatch::Place& knot : knots) {
        points.push_back(knot.position);
        at.push_back(knot.t);
    }
    at.push_back(at.front() + period);
    return interpolate_periodic(points, std::move(at));
}

}  // namespace cmm::fitting
