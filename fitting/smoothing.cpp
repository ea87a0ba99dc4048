// SPDX-License-Identifier: Apache-2.0
#include "fitting/smoothing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "fitting/band_solver.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;
using Cubic = std::array<double, 4>;
using SpanBasis = std::array<Cubic, 4>;  // the four B-splines that live on a span, as polynomials of u = t - t_k

constexpr std::size_t least_points = 12;
constexpr double sigma_floor_mm =
    1e-4;  // below 0.1 um nothing is resolved: noise-free data do not ask for endless knots
constexpr double gross_misfit_mm = 1e-3;

/// Basis of span k by the recursion of seed 000, eq 7, carried out on polynomials; `knot(i)` continues over the period.
template <class Knot>
SpanBasis span_basis(const Knot& knot, std::ptrdiff_t k) {
    const double origin = knot(k);
    SpanBasis basis{};
    basis[0][0] = 1.0;
    for (int degree = 1; degree <= 3; ++degree) {
        SpanBasis next{};
        for (int j = 0; j < degree; ++j) {
            // N_{i,degree-1} with i = k - degree + 1 + j feeds N_{i-1,degree} and N_{i,degree}.
            const std::ptrdiff_t i = k - degree + 1 + j;
            const double low = knot(i) - origin, high = knot(i + degree) - origin, width = high - low;
            for (int power = 0; power < degree; ++power) {
                const double value = basis[j][power] / width;
                next[j][power] += high * value;
                next[j][power + 1] -= value;
                next[j + 1][power] -= low * value;
                next[j + 1][power + 1] += value;
            }
        }
        basis = next;
    }
    return basis;
}

double value_of(const Cubic& p, double u) {
    return p[0] + u * (p[1] + u * (p[2] + u * p[3]));
}

/// 99.9 % limit of a chi-square with n degrees of freedom (Wilson and Hilferty 1931).
double chi_square_limit(double n) {
    const double a = 2.0 / (9.0 * n), root = 1.0 - a + 3.1 * std::sqrt(a);
    return n * root * root * root;
}

class Smoother {
  public:
    Smoother(std::span<const Vec2> points, double sigma, std::size_t least_per_span)
        : input_(points),
          sigma_(std::max(sigma, sigma_floor_mm)),
          least_per_span_(least_per_span),
          order_(points.size()) {
        std::iota(order_.begin(), order_.end(), std::size_t{0});
        parametrise_by_chords();
        sort_points();
        place_first_knots();
    }

    core::Status run() {
        for (int pass = 0; pass < 2; ++pass) {
            for (int round = 0; round < 12; ++round) {
                if (!solve()) return core::fail(ErrorCode::fit_not_evaluable, "smoothing spline: singular system");
                if (!split_spans()) break;
            }
            if (pass == 0) parametrise_by_curve();
        }
        return {};
    }

    SmoothCurve result() && {
        SmoothCurve out;
        const std::size_t n = points_.size();
        out.parameter.resize(n);
        out.residual.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            out.parameter[order_[i]] = t_[i];
            out.residual[order_[i]] = residual_[i];
        }
        const std::size_t spans = first_.size() - 1;
        out.leverage.resize(spans);
        for (std::size_t k = 0; k < spans; ++k) {
            const std::size_t held = count(k) + count((k + 1) % spans) + count((k + spans - 1) % spans);
            out.leverage[k] = std::min(1.0, 3.0 / static_cast<double>(held));
        }
        out.curve = std::move(curve_);
        return out;
    }

  private:
    std::size_t count(std::size_t span) const { return first_[span + 1] - first_[span]; }

    /// Chord lengths between anchors that are clearly farther apart than the noise; the points between are projected.
    void parametrise_by_chords() {
        const std::size_t n = input_.size();
        const double apart = 12.0 * sigma_;
        t_.assign(n, 0.0);
        std::size_t anchor = 0;
        const auto project = [&](std::size_t from, std::size_t to, const Vec2& end) {
            const Vec2 chord = end - input_[from];
            const double squared = chord.squaredNorm(), length = std::sqrt(squared);
            for (std::size_t k = from + 1; k < to; ++k) {
                const double share = squared > 0.0 ? (input_[k] - input_[from]).dot(chord) / squared : 0.0;
                t_[k] = t_[from] + std::clamp(share, 0.0, 1.0) * length;
            }
            return t_[from] + length;
        };
        for (std::size_t i = 1; i < n; ++i) {
            if ((input_[i] - input_[anchor]).norm() < apart) continue;
            t_[i] = project(anchor, i, input_[i]);
            anchor = i;
        }
        period_ = project(anchor, n, input_[0]);
    }

    void sort_points() {
        std::vector<std::size_t> by_t(t_.size());
        std::iota(by_t.begin(), by_t.end(), std::size_t{0});
        std::stable_sort(by_t.begin(), by_t.end(), [&](std::size_t a, std::size_t b) { return t_[a] < t_[b]; });
        std::vector<double> t(t_.size());
        std::vector<std::size_t> order(t_.size());
        points_.resize(t_.size());
        for (std::size_t i = 0; i < by_t.size(); ++i) {
            t[i] = t_[by_t[i]];
            order[i] = order_[by_t[i]];
            points_[i] = input_[order[i]];
        }
        t_ = std::move(t);
        order_ = std::move(order);
        residual_.assign(t_.size(), 0.0);
    }

    void place_first_knots() {
        const std::size_t n = points_.size();
        const std::size_t spans = std::min(n, std::max<std::size_t>(16, n / 24));
        first_.clear();
        for (std::size_t k = 0; k <= spans; ++k)
            push_knot(first_, k * n / spans);
        first_.back() = n;
    }

    /// Knots sit on points; two knots on the same parameter are one.
    void push_knot(std::vector<std::size_t>& knots, std::size_t first) const {
        if (!knots.empty() && first < points_.size() && t_[first] - t_[knots.back()] < 1e-9 * period_) return;
        knots.push_back(first);
    }

    double knot(std::ptrdiff_t k) const {
        const auto spans = static_cast<std::ptrdiff_t>(first_.size()) - 1;
        const std::ptrdiff_t turns = k >= 0 ? k / spans : -((spans - 1 - k) / spans);
        return t_[first_[static_cast<std::size_t>(k - turns * spans)]] + static_cast<double>(turns) * period_;
    }

    bool solve() {
        const std::size_t spans = first_.size() - 1;
        if (spans < 7) return false;
        BandSolver<3> normal(spans, true);
        std::vector<Vec2> control(spans, Vec2::Zero());
        std::vector<SpanBasis> bases(spans);
        for (std::size_t k = 0; k < spans; ++k) {
            bases[k] = span_basis([this](std::ptrdiff_t i) { return knot(i); }, static_cast<std::ptrdiff_t>(k));
            std::array<std::array<double, 4>, 4> gram{};
            std::array<Vec2, 4> moment{Vec2::Zero(), Vec2::Zero(), Vec2::Zero(), Vec2::Zero()};
            for (std::size_t i = first_[k]; i < first_[k + 1]; ++i) {
                const double u = t_[i] - t_[first_[k]];
                std::array<double, 4> b{};
                for (std::size_t a = 0; a < 4; ++a) {
                    b[a] = value_of(bases[k][a], u);
                    moment[a] += b[a] * points_[i];
                    for (std::size_t c = 0; c <= a; ++c)
                        gram[a][c] += b[a] * b[c];
                }
            }
            for (std::size_t a = 0; a < 4; ++a) {
                control[(k + a) % spans] += moment[a];
                for (std::size_t c = 0; c <= a; ++c)
                    normal.add((k + a) % spans, (k + c) % spans, gram[a][c]);
            }
        }
        if (!normal.factor()) return false;
        normal.solve(std::span(control));
        build_curve(bases, control);
        return true;
    }

    void build_curve(const std::vector<SpanBasis>& bases, const std::vector<Vec2>& control) {
        const std::size_t spans = bases.size();
        std::vector<double> breaks(spans + 1);
        std::vector<PiecewiseCubic::Piece> pieces(spans);
        for (std::size_t k = 0; k < spans; ++k) {
            breaks[k] = t_[first_[k]];
            for (std::size_t power = 0; power < 4; ++power) {
                pieces[k][power] = Vec2::Zero();
                for (std::size_t a = 0; a < 4; ++a)
                    pieces[k][power] += bases[k][a][power] * control[(k + a) % spans];
            }
        }
        breaks[spans] = breaks[0] + period_;
        curve_ = PiecewiseCubic(std::move(breaks), std::move(pieces), true);
        for (std::size_t k = 0; k < spans; ++k) {
            for (std::size_t i = first_[k]; i < first_[k + 1]; ++i) {
                const Jet jet = curve_.jet_in(k, t_[i]);
                residual_[i] = (points_[i] - jet.position).dot(jet.right_normal());
            }
        }
    }

    /// Fewer points than usual only against a gross misfit, and a knot on every point (interpolation, which would
    /// follow bad points) only where the points are so sparse that the curve turns by a quarter of a radian from one to
    /// the next.
    std::size_t least_in(std::size_t span, bool gross) const {
        if (!gross || least_per_span_ > 3) return least_per_span_;
        const auto& pieces = curve_.pieces();
        const double turn = std::abs(turn_angle(pieces[span][1], pieces[(span + 1) % pieces.size()][1]));
        return turn > 0.12 * static_cast<double>(count(span)) ? 1 : 2;
    }

    /// Halves every span whose residuals are too large or follow each other; false when none is.
    bool split_spans() {
        const std::size_t n = points_.size(), spans = first_.size() - 1;
        const std::vector<std::size_t> knots = first_;
        std::vector<std::size_t> finer;
        bool any = false;
        for (std::size_t k = 0; k < spans; ++k) {
            push_knot(finer, knots[k]);
            const std::size_t held = knots[k + 1] - knots[k];
            if (held < 2) continue;
            double squares = 0.0, products = 0.0;
            for (std::size_t i = knots[k]; i < knots[k + 1]; ++i) {
                squares += residual_[i] * residual_[i];
                products += residual_[i] * residual_[(i + 1) % n];
            }
            const double variance = sigma_ * sigma_, amount = static_cast<double>(held);
            const bool misfit =
                squares > variance * chi_square_limit(amount) || products > variance * 3.0 * std::sqrt(amount);
            const bool gross = squares > amount * std::pow(std::max(3.0 * sigma_, gross_misfit_mm), 2);
            if (!misfit || held < 2 * least_in(k, gross)) continue;
            const std::size_t before = finer.size();
            push_knot(finer, knots[k] + held / 2);
            any = any || finer.size() > before;
        }
        finer.push_back(n);
        first_ = std::move(finer);
        return any;
    }

    /// The points' feet on the curve replace the chord lengths, so that noise and gaps leave the parameter alone.
    void parametrise_by_curve() {
        const double start = t_[first_[0]];
        for (std::size_t k = 0; k + 1 < first_.size(); ++k) {
            for (std::size_t i = first_[k]; i < first_[k + 1]; ++i) {
                const Jet jet = curve_.jet_in(k, t_[i]);
                const double move = (points_[i] - jet.position).dot(jet.d1) / std::max(jet.d1.squaredNorm(), 1e-12);
                // A knot stays inside the period; others may pass each other and are sorted again.
                t_[i] = std::clamp(t_[i] + move, start, start + period_ * (1.0 - 1e-12));
            }
        }
        std::vector<double> at;
        for (std::size_t k = 0; k + 1 < first_.size(); ++k)
            at.push_back(t_[first_[k]]);
        std::sort(at.begin(), at.end());
        sort_points();
        first_.clear();
        push_knot(first_, 0);
        for (std::size_t k = 1; k < at.size(); ++k) {
            const auto found = std::lower_bound(t_.begin(), t_.end(), at[k]);
            const auto index = static_cast<std::size_t>(found - t_.begin());
            if (index < points_.size()) push_knot(first_, index);
        }
        first_.push_back(points_.size());
    }

    std::span<const Vec2> input_;
    double sigma_;
    std::size_t least_per_span_;
    std::vector<std::size_t> order_;  // sorted position -> input index
    std::vector<Vec2> points_;        // sorted by parameter
    std::vector<double> t_, residual_;
    std::vector<std::size_t> first_;  // first point of each span; the last entry is the number of points
    double period_ = 0.0;
    PiecewiseCubic curve_;
};

}  // namespace

core::Result<SmoothCurve> smooth_closed(std::span<const Vec2> points, double sigma_mm, std::size_t least_per_span) {
    if (points.size() < least_points)
        return core::fail(ErrorCode::fit_not_evaluable, "smoothing spline: needs " + std::to_string(least_points) +
                                                            " points, got " + std::to_string(points.size()));
    Smoother smoother(points, sigma_mm, least_per_span);
    if (const auto status = smoother.run(); !status) return tl::unexpected(status.error());
    return std::move(smoother).result();
}

}  // namespace cmm::fitting
