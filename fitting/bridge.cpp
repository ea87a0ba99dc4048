// SPDX-License-Identifier: Apache-2.0
#include "fitting/bridge.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "fitting/circle_frame.hpp"
#include "fitting/orthogonal_polynomials.hpp"
#include "fitting/spline_residual.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t most_points = 2 * Neighbours::most;
constexpr std::size_t both_sides = 6;  // points a side of a joint fit
constexpr std::size_t short_side = 3;  // where the longer ones hold a corner
constexpr std::size_t highest_degree = 6, highest_short_degree = 3, highest_side_degree = 4, lowest_degree = 2;
constexpr double sharp_sd = 1.9;  // in sigmas: so near do both sides together predict a point
constexpr double supporting_ratio = 3.0, contradicting_ratio = 4.0, reject_ratio = 5.0;  // of standard deviations
constexpr double doubt_factor = 3.0;
constexpr double supporting_sd = 2.0;  // in sigmas
constexpr double steep_rad = 1.0;
constexpr double beside = 1.6;          // steps
constexpr double meeting_factor = 4.0;  // likewise
constexpr double most_leverage = 30.0;  // of one side's extrapolation: beyond, it is no witness

struct Prediction {
    double residual = 0.0, sd = 0.0;  // of a point from the polynomial; of that difference for a good point
    double leverage = 0.0;
    double ratio() const { return std::abs(residual) / sd; }
};

/// The polynomial of least squares through points of a CircleFrame.
class Polynomial {
  public:
    explicit Polynomial(const CircleFrame& frame) : frame_(frame) {}

    void add(const Vec2& p) {
        const Vec2 q = frame_.local(p);
        if (frame_.is_far(q.x())) return;
        x_[static_cast<Eigen::Index>(count_)] = q.x();
        y_[static_cast<Eigen::Index>(count_++)] = q.y();
    }
    std::size_t count() const { return count_; }

    /// Chooses the lowest degree whose residuals are like noise and whose two following terms are not real, or the
    /// highest allowed one if its residuals are like noise. False when there is none.
    bool fit(double sigma, std::size_t most_degree, double term_factor) {
        term_limit_ = term_factor * term_factor * sigma * sigma;
        if (count_ < lowest_degree + 2) return false;
        variance_ = sigma * sigma;
        Values there = Values::Zero();
        there.head(static_cast<Eigen::Index>(count_)) = 1.0;
        x_ = (there > 0.0).select(x_, x_[0]);
        y_ *= there;
        terms_.begin(x_, there);
        take_term();
        most_degree = std::min(most_degree, count_ - 2);
        const std::size_t top = std::min(count_ - 1, most_degree + 2);
        bool told = true;
        while (terms_.degree() < top && (told = terms_.raise())) {
            take_term();
            if (terms_.degree() >= lowest_degree + 2 && accepts(terms_.degree() - 2)) return true;
        }
        degree_ = told ? terms_.degree() - 1 : terms_.degree();
        return degree_ >= lowest_degree && degree_ <= most_degree && like_noise(degree_);
    }

    /// `doubted` terms beyond the degree count as error of the model as far as they are larger than their noise.
    Prediction predict(const Vec2& p, std::size_t doubted) const {
        const Vec2 q = frame_.local(p);
        double value = 0.0, model = 0.0;
        Prediction out;
        terms_.at(q.x(), std::min(terms_.degree(), degree_ + doubted), [&](std::size_t j, double of_term) {
            const double term = c_[j] * of_term, share = of_term * of_term / terms_.norm_of(j);
            if (j <= degree_) {
                value += term;
                out.leverage += share;
            } else {
                model += std::max(0.0, term * term - variance_ * share);
            }
        });
        out.residual = q.y() - value;
        out.sd = std::sqrt(variance_ * (1.0 + out.leverage) + model);
        return out;
    }

  private:
    using Values = Eigen::Array<double, most_points, 1>;

    void take_term() {
        const std::size_t degree = terms_.degree();
        const Values& now = terms_.values_of(degree);
        const double moment = (now * y_).sum(), c = moment / terms_.norm_of(degree);
        y_ -= c * now;
        c_[degree] = c;
        squares_[degree] = y_.square().sum();
        real_[degree] = moment * c > term_limit_;
    }

    bool like_noise(std::size_t degree) const {
        return squares_[degree] <= variance_ * chi_square_limit_999(count_ - degree - 1);
    }

    bool accepts(std::size_t degree) {
        degree_ = degree;
        return !real_[degree + 1] && !real_[degree + 2] && like_noise(degree);
    }

    CircleFrame frame_;
    OrthogonalPolynomials<Values, highest_degree + 2> terms_;
    Values x_ = Values::Zero(), y_ = Values::Zero();  // y becomes the residual
    std::array<double, highest_degree + 3> c_{}, squares_{};
    std::array<bool, highest_degree + 3> real_{};
    std::size_t count_ = 0, degree_ = 0;
    double variance_ = 0.0, term_limit_ = 0.0;
};

using Side = std::array<Vec2, Neighbours::most>;

/// A smooth curve through both sides of the gap, if there is one.
std::optional<Polynomial> through_both(const Neighbours& near, std::size_t side, std::size_t most_degree,
                                       double sigma) {
    const std::size_t before = std::min(side, near.count_before), after = std::min(side, near.count_after);
    if (before < 2 || after < 2) return std::nullopt;
    Polynomial joint(CircleFrame(near.before[before - 1], near.before[0], near.after[after - 1]));
    for (std::size_t k = before; k-- > 0;)
        joint.add(near.before[k]);
    for (std::size_t k = 0; k < after; ++k)
        joint.add(near.after[k]);
    return joint.fit(sigma, most_degree, 3.0) ? std::optional(joint) : std::nullopt;
}

/// The smooth curve through the longest stretch next to the gap on one side.
std::optional<Polynomial> through_side(std::span<const Vec2> side, double sigma) {
    for (std::size_t used = side.size(); used >= 4; used -= used > 6 ? 2 : 1) {
        Polynomial one(CircleFrame(side[used - 1], side[used / 2], side[0]));
        for (std::size_t k = used; k-- > 0;)
            one.add(side[k]);
        if (one.fit(sigma, highest_side_degree, 1.4)) return one;
    }
    return std::nullopt;
}

/// What both sides, each for itself, say of a point between them; the residual of the second in the sense of the first.
struct Sides {
    std::optional<Polynomial> curve_before, curve_after;
    Prediction before, after;

    Sides(const Neighbours& near, double sigma)
        : curve_before(through_side(std::span(near.before).first(near.count_before), sigma)),
          curve_after(through_side(std::span(near.after).first(near.count_after), sigma)) {}

    void predict(const Vec2& p) {
        if (curve_before) before = curve_before->predict(p, 1);
        if (curve_after) after = curve_after->predict(p, 1);
        after.residual = -after.residual;
        if (before.leverage > most_leverage) curve_before.reset();
        if (after.leverage > most_leverage) curve_after.reset();
    }

    /// Whether the two curves come together between `from` and `to`: otherwise there is no corner but a step, which no
    /// contour has.
    bool meet(const Vec2& from, const Vec2& to) const {
        double last = 0.0;
        for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
            const Vec2 p = from + share * (to - from);
            const Prediction one = curve_before->predict(p, 1), other = curve_after->predict(p, 1);
            const double apart = one.residual + other.residual;
            if (std::abs(apart) <= meeting_factor * std::hypot(one.sd, other.sd) || apart * last < 0.0) return true;
            last = apart;
        }
        return false;
    }
};

/// The four-neighbour test (seed 000, A8), and what sampling alone can make of it: on a circle, steps h of angle g
/// leave h g^3 / 6; where the curvature jumps by d (edge to side) h^2 d / 16. Twice and once that.
struct FourNeighbours {
    double residual = 0.0, sd = 0.0, sampling = 0.0;

    FourNeighbours(const Neighbours& near, const Vec2& p, double sigma) {
        if (near.count_before < 2 || near.count_after < 2) return;
        const Vec2 across = near.after[0] - near.before[0];
        const double gap = across.norm();
        // Left and right again: the neighbours themselves are on different levels.
        const std::size_t back = near.count_before > 2 ? 2 : 1, ahead = near.count_after > 2 ? 2 : 1;
        const Vec2 in = near.before[0] - near.before[back], out = near.after[ahead] - near.after[0];
        if (std::abs(turn_angle(in, across) - turn_angle(across, out)) > steep_rad) return;
        const auto outer = [&](const Side& side, std::size_t count) {
            std::size_t k = 1;
            while (k < 4 && k + 1 < count && (side[k] - side[0]).norm() < 0.35 * gap)
                ++k;
            return side[k];
        };
        const SplineResidual found = spline_residual(outer(near.before, near.count_before), near.before[0],
                                                     near.after[0], outer(near.after, near.count_after), p);
        residual = found.distance_mm;
        sd = found.gain * sigma;
        const auto bend = [](const Side& side, std::size_t count) {
            if (count < 3) return 0.0;
            const CircleFrame near_frame(side[0], side[1], side[2]);
            if (count < 5) return near_frame.curvature();
            const bool sharp = std::abs(near_frame.curvature()) * (side[2] - side[0]).norm() > 0.5;
            return sharp ? near_frame.curvature() : CircleFrame(side[0], side[2], side[4]).curvature();
        };
        const double before = -bend(near.before, near.count_before), after = bend(near.after, near.count_after);
        const double h = 0.5 * gap, g = std::min(1.5, 0.5 * h * std::abs(before + after));
        sampling = h * g * g * g / 3.0 + h * h * std::abs(after - before) / 16.0;
        // Turning that no curvature between the two explains is a corner: at most a quarter of angle times gap.
        const double base_in = in.norm(), base_out = out.norm(), mean = 0.5 * (before + after);
        const double turn = turn_angle(in, out) - 0.5 * before * base_in - mean * gap - 0.5 * after * base_out;
        const double excused =
            0.5 * std::abs(after - before) * gap + 3.0 * 1.5 * sigma * (1.0 / base_in + 1.0 / base_out);
        sampling += 0.25 * gap * std::max(0.0, std::abs(turn) - excused);
    }
};

Verdict verdict_of(const Prediction& prediction, bool corner) {
    return {prediction.residual, prediction.sd, true, false, corner};
}

/// The two sides are not one smooth curve: a point belongs to the one that it continues, if the corner lies beyond it.
Verdict judge_at_corner(const Sides& sides, const Neighbours& near, const Vec2& p) {
    const bool two = sides.curve_before && sides.curve_after;
    const auto supports = [&](const Prediction& one, const Prediction& other, const Vec2& far_end) {
        if (one.ratio() >= contradicting_ratio) return false;
        return !two || other.ratio() < contradicting_ratio || sides.meet(p, far_end);
    };
    const bool by_before = sides.curve_before && supports(sides.before, sides.after, near.after[0]);
    const bool by_after = sides.curve_after && supports(sides.after, sides.before, near.before[0]);
    const bool end = near.count_before == 0 || near.count_after == 0;
    if (!sides.curve_before && !sides.curve_after) return {};
    const bool after_is_surer = sides.curve_after && (!sides.curve_before || sides.after.sd < sides.before.sd);
    const Prediction& surer = after_is_surer ? sides.after : sides.before;
    const Prediction& other = after_is_surer ? sides.before : sides.after;
    if (after_is_surer ? by_after : by_before) return verdict_of(surer, !end);
    // The other side must tell the point from what the surer one predicts.
    const bool owned = (after_is_surer ? by_before : by_after) && other.ratio() < supporting_ratio &&
                       std::abs(surer.residual) > reject_ratio * other.sd;
    if (owned) return verdict_of(other, true);
    Verdict out = verdict_of(surer, !end);
    // One side of a corner cannot condemn a point that may belong to the other.
    out.resolved = two || end;
    return out;
}

}  // namespace

Verdict judge_beyond(std::span<const Vec2> side, const Vec2& p, double sigma_mm) {
    const auto curve = through_side(side.first(std::min(side.size(), most_points)), sigma_mm);
    if (!curve) return {};
    const Prediction beyond = curve->predict(p, 1);
    return beyond.leverage > most_leverage ? Verdict{} : verdict_of(beyond, false);
}

Verdict judge_point(const Neighbours& near, const Vec2& p, double sigma_mm) {
    auto joint = through_both(near, both_sides, highest_degree, sigma_mm);
    if (!joint) joint = through_both(near, short_side, highest_short_degree, sigma_mm);
    Prediction best;
    if (joint) {
        best = joint->predict(p, 2);
        if (best.sd <= sharp_sd * sigma_mm && best.ratio() < contradicting_ratio)
            return {best.residual, best.sd, true, true, false};
    }
    Sides sides(near, sigma_mm);
    sides.predict(p);
    // A smooth curve over a corner is not what the nearer side says.
    const bool by_after = sides.curve_after && (!sides.curve_before || sides.after.sd < sides.before.sd);
    if (joint && (by_after || sides.curve_before)) {
        const Prediction& near_side = by_after ? sides.after : sides.before;
        if (std::abs(best.residual - near_side.residual) > doubt_factor * std::hypot(best.sd, near_side.sd))
            joint.reset();
    }
    if (joint) {
        const bool one_sided =
            (sides.curve_before && sides.before.sd < best.sd) || (sides.curve_after && sides.after.sd < best.sd);
        if (one_sided) best = by_after ? sides.after : sides.before;
        Verdict out = verdict_of(best, one_sided && near.count_before > 0 && near.count_after > 0);
        out.sharp = !one_sided && best.sd <= sharp_sd * sigma_mm;
        return out;
    }
    const FourNeighbours four(near, p, sigma_mm);
    if (four.sd > 0.0) {
        if (std::abs(four.residual) <= supporting_ratio * four.sd) return {four.residual, four.sd, true, false, false};
        // A side that ends right beside the point and predicts it sharply is heard before four points over a corner.
        const auto agrees = [&](const auto& curve, const Prediction& one, const Side& side) {
            return curve && one.sd < supporting_sd * sigma_mm && one.ratio() < supporting_ratio &&
                   (side[0] - p).norm() < beside * (side[1] - side[0]).norm();
        };
        const double sd = four.sd + four.sampling / reject_ratio;
        const bool supported =
            agrees(sides.curve_before, sides.before, near.before) || agrees(sides.curve_after, sides.after, near.after);
        if (!supported && std::abs(four.residual) > reject_ratio * sd) return {four.residual, sd, true, false, false};
    }
    return judge_at_corner(sides, near, p);
}

}  // namespace cmm::fitting
