// SPDX-License-Identifier: Apache-2.0
#include "fitting/contour.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/text.hpp"
#include "fitting/cyclic.hpp"
#include "fitting/edge_fit.hpp"
#include "fitting/edges.hpp"
#include "fitting/fairing.hpp"
#include "fitting/gaps.hpp"
#include "fitting/join.hpp"
#include "fitting/lack_of_fit.hpp"
#include "fitting/offset.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr double spread_by_turning = 0.25;     // of the contour points that are spread by turning, the rest by length
constexpr double least_measured = 0.1;         // share of a contour, by which its points become more at most
constexpr double most_off_model_sigmas = 4.0;  // of a curve that other sections know as well

/// What a curve may have flattened, at ascending parameters once round from a first one on.
class FlattenedAlong {
  public:
    FlattenedAlong(const SmoothCurve& smooth, double first_t)
        : curve_(smooth.curve),
          parameter_(smooth.parameter),
          by_point_(flattened_mm(smooth.residual, smooth.leverage, smooth.sigma_mm)) {
        const auto next = std::lower_bound(parameter_.begin(), parameter_.end(), first_t);
        next_ = static_cast<std::size_t>(next - parameter_.begin()) % parameter_.size();
    }

    double at(double t) {
        const std::size_t n = parameter_.size();
        // What is more than half way round ahead lies behind.
        const double half = 0.5 * curve_.period();
        for (std::size_t walked = 0; walked < n && curve_.ahead(t, parameter_[next_]) > half; ++walked)
            next_ = next_ + 1 < n ? next_ + 1 : 0;
        const std::size_t last = next_ > 0 ? next_ - 1 : n - 1;
        const double step = curve_.ahead(parameter_[last], parameter_[next_]), on = curve_.ahead(parameter_[last], t);
        const double share = on < step ? on / step : 1.0;
        return by_point_[last] + share * (by_point_[next_] - by_point_[last]);
    }

  private:
    const PiecewiseCubic& curve_;
    std::span<const double> parameter_;
    std::vector<double> by_point_;
    std::size_t next_ = 0;
};

class ContourBuilder {
  public:
    ContourBuilder(const SmoothCurve& smooth, std::span<const Vec2> good, const SectionOptions& options,
                   SectionFit& fit, std::span<const SurfaceStation> surface)
        : smooth_(smooth),
          good_(good),
          options_(options),
          fit_(fit),
          surface_(surface),
          noise_(smooth.noise),
          gaps_(find_gaps(good, options)) {}

    core::Result<OpenEdges> run() {
        const std::size_t dense = 2 * std::max<std::size_t>(options_.contour_points, 400);
        const double r = options_.ball_radius_mm;
        auto part = offset_inwards(smooth_.curve, r, dense).points;
        auto edges = find_edges(part, options_.le_hint, options_.te_hint);
        if (!edges) return tl::unexpected(edges.error());
        const Noise noise = noise_of(smooth_, good_.size());
        const std::vector<double> leverage = left_to_points();
        const EdgeFitter fitter({smooth_, good_, part, r, noise, gaps_, leverage});
        coverage_ = coverage_95(noise.freedom);
        const bool need_le = fitter.may_patch(edges->le, edges->te), need_te = fitter.may_patch(edges->te, edges->le);
        EdgeAnswer le_answer, te_answer;
        if (need_le) fit_.le = take(fitter.run(edges->le, edges->te, options_.le_model), le_answer);
        if (need_te) fit_.te = take(fitter.run(edges->te, edges->le, options_.te_model), te_answer);
        OpenEdges open{{}, *edges, {}, r, options_.le_model, options_.te_model, !need_le, !need_te};
        if (!patches_.empty() || options_.fairing_mm > 0.0) {
            const Vec2 le = part[edges->le.nose].position, te = part[edges->te.nose].position;
            auto curve = join_edges(smooth_.curve, patches_);
            if (auto status = fair(curve); !status) return tl::unexpected(status.error());
            open.part = std::exchange(part, offset_inwards(curve, r, dense).points);
            edges = find_edges(part, le, te);
            if (!edges) return tl::unexpected(edges.error());
        }
        publish(part, *edges);
        answer_by_contour(le_answer, smooth_.curve, fit_.contour, fit_.le);
        answer_by_contour(te_answer, smooth_.curve, fit_.contour, fit_.te);
        if (open.part.empty()) open.part = std::move(part);
        open.gaps = std::move(gaps_);
        return open;
    }

  private:
    /// The leverage of the points, of which other sections have taken a share.
    std::vector<double> left_to_points() const {
        std::vector<double> leverage;
        for (std::size_t i = 0; i < good_.size() && !surface_.empty(); ++i) {
            const double share = stations_at(smooth_.parameter[i])(&SurfaceStation::noise_share);
            leverage.push_back(share * share * smooth_.leverage[i]);
        }
        return leverage;
    }

    EdgeFit take(EdgeOutcome outcome, EdgeAnswer& answer) {
        answer = std::move(outcome.answer);
        outcome.fit.used_in_contour = outcome.patch && !contradicted(*outcome.patch);
        if (outcome.fit.used_in_contour) patches_.push_back(std::move(*outcome.patch));
        return std::move(outcome.fit);
    }

    /// By what the other sections know: the points of this one alone may bear a model that the part does not have.
    /// Where they took no share, the curve has the points that the model has, and says nothing against it.
    bool contradicted(const EdgePatch& patch) {
        if (surface_.empty()) return false;
        const auto places = patch.places(smooth_.curve);
        return std::any_of(places.begin(), places.end(), [&](const EdgePatch::Place& place) {
            const double t = smooth_.curve.wrap(place.t);
            const Jet jet = smooth_.curve.jet(t);
            const double share = stations_at(t)(&SurfaceStation::noise_share);
            if (share == 1.0) return false;
            const double sigma_mm = share * noise_.sigma_mm(t);
            return std::abs((place.position - jet.position).dot(jet.right_normal())) > most_off_model_sigmas * sigma_mm;
        });
    }

    /// Only when it was asked for; what it moves the contour by counts as uncertainty.
    core::Status fair(PiecewiseCubic& curve) {
        if (!(options_.fairing_mm > 0.0)) return {};
        auto faired = fair_closed(curve, options_.fairing_mm);
        if (!faired) return tl::unexpected(faired.error());
        curve = std::move(faired->curve);
        fit_.faired_mm = faired->largest_mm;
        return {};
    }

    void publish(const std::vector<OffsetPoint>& part, const BladeEdges& edges) {
        const auto zones = zones_of(edges, part.size());
        fit_.le_point_mm = nose_of(edges.le, part);
        fit_.te_point_mm = nose_of(edges.te, part);
        fit_.chord_mm = (fit_.te_point_mm - fit_.le_point_mm).norm();
        fit_.le_scale_mm = edges.le.scale_mm;
        fit_.te_scale_mm = edges.te.scale_mm;
        fit_.contour_noise = ContourNoise(smooth_.noise, patches_, smooth_.curve.period(), coverage_);
        resample(part, zones, edges.le.nose);
        set_arc_lengths(fit_.contour);
    }

    /// Equal steps of a mixed measure of length and turning, from the LE nose on.
    void resample(const std::vector<OffsetPoint>& part, const std::vector<Zone>& zones, std::size_t first) {
        const std::size_t n = part.size();
        const auto at = [&](std::size_t k) { return cyclic(first + k, n); };
        std::vector<double> length(n + 1, 0.0), turn(n + 1, 0.0), measure(n + 1);
        for (std::size_t k = 0; k < n; ++k) {
            const OffsetPoint &a = part[at(k)], &b = part[at(k + 1)];
            length[k + 1] = length[k] + (b.position - a.position).norm();
            turn[k + 1] = turn[k] + std::abs(turn_between(a.normal, b.normal));
        }
        for (std::size_t k = 0; k <= n; ++k)
            measure[k] = (1.0 - spread_by_turning) * length[k] / length[n] + spread_by_turning * turn[k] / turn[n];
        const auto was_measured = [&](double t) {
            return std::none_of(gaps_.begin(), gaps_.end(), [&](const Gap& gap) { return lies_in(gap, t); });
        };
        double missing = 0.0;  // share of the measure; the points asked for are those beside it
        for (std::size_t k = 0; k < n && !gaps_.empty(); ++k)
            if (!was_measured(smooth_.curve.wrap(part[at(k)].t))) missing += measure[k + 1] - measure[k];
        const auto count = static_cast<std::size_t>(
            std::lround(static_cast<double>(options_.contour_points) / std::max(1.0 - missing, least_measured)));
        fit_.contour.resize(count);
        const double offset_error = lean_error(options_.ball_radius_mm, options_.lean_rad).in_plane_mm;
        FlattenedAlong flattened(smooth_, smooth_.curve.wrap(part[first].t));
        std::size_t k = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const double wanted = static_cast<double>(i) / static_cast<double>(count);
            while (k + 1 < n && measure[k + 1] <= wanted)
                ++k;
            const OffsetPoint &a = part[at(k)], &b = part[at(k + 1)];
            const double share = on_grid((wanted - measure[k]) / std::max(measure[k + 1] - measure[k], 1e-300));
            ContourPoint& out = fit_.contour[i];
            out.position_mm = a.position + share * (b.position - a.position);
            out.normal = (a.normal + share * (b.normal - a.normal)).normalized();
            out.zone = zones[at(k)];
            out.offset_error_mm = offset_error;
            out.u95_mm = noise_uncertainty(a, 1.0) + fit_.faired_mm + offset_error;
            out.bound_mm = fit_.faired_mm;
            out.t = smooth_.curve.wrap(a.t);
            out.reached = !a.on_arc;
            out.measured = was_measured(out.t);
            out.flattened_mm = flattened.at(out.t);
            if (!surface_.empty()) take_surface(a, out);
        }
    }

    /// A share of a step, to its sixty-fourth: what rounding does to the turning along flat sides does not move the
    /// places there.
    static double on_grid(double share) { return std::round(std::clamp(share, 0.0, 1.0) * 64.0) / 64.0; }

    /// The stations before and behind a parameter, and how far it is from one to the other.
    struct Stations {
        const SurfaceStation &last, &next;
        double share;
        double operator()(double SurfaceStation::*value) const {
            return last.*value + share * (next.*value - last.*value);
        }
        /// Its size between theirs, its sign that of the nearer one.
        double drawn_doubt_mm() const {
            const double from = std::abs(last.drawn_doubt_mm), to = std::abs(next.drawn_doubt_mm);
            return std::copysign(from + share * (to - from), (share < 0.5 ? last : next).drawn_doubt_mm);
        }
    };
    Stations stations_at(double t) const {
        const auto above = std::upper_bound(surface_.begin(), surface_.end(), t,
                                            [](double value, const SurfaceStation& s) { return value < s.t; });
        const SurfaceStation& next = above != surface_.end() ? *above : surface_.front();
        const SurfaceStation& last = above != surface_.begin() ? *(above - 1) : surface_.back();
        const double share = smooth_.curve.ahead(last.t, t) / std::max(smooth_.curve.ahead(last.t, next.t), 1e-300);
        return {last, next, std::clamp(share, 0.0, 1.0)};
    }

    void take_surface(const OffsetPoint& at, ContourPoint& out) {
        const Stations between = stations_at(smooth_.curve.wrap(at.t));
        out.rise = std::tan(between(&SurfaceStation::lean_rad));
        out.noise_share = between(&SurfaceStation::noise_share);
        out.scatter_share = between(&SurfaceStation::scatter_share);
        out.kept_share = between(&SurfaceStation::kept_share);
        out.bound_mm = fit_.faired_mm + between(&SurfaceStation::lean_doubt_mm);
        out.drawn_mm = between.drawn_doubt_mm();
        out.u95_mm = noise_uncertainty(at, out.noise_share) + out.bound_mm;
        if (between.last.moved && between.next.moved) {
            out.lean_rad = between(&SurfaceStation::lean_rad);
        } else {
            out.offset_error_mm = between(&SurfaceStation::offset_error_mm);
            out.u95_mm += out.offset_error_mm;
        }
    }

    /// Or beside it.
    bool lies_in(const Gap& gap, double t) const {
        const std::size_t n = good_.size();
        const double from = smooth_.parameter[(gap.before + n - beside_gap) % n];
        const double to = smooth_.parameter[(gap.behind + beside_gap) % n];
        return from < to ? t > from && t < to : t > from || t < to;
    }

    /// Student's factor (95 %) times the noise that the smoothing or an edge's model leaves; of the first a share.
    double noise_uncertainty(const OffsetPoint& point, double share) {
        const double t = smooth_.curve.wrap(point.t);
        double sigma = share * noise_.sigma_mm(t);
        for (const EdgePatch& patch : patches_)
            if (const auto own = patch.sigma_mm(t, smooth_.curve.period(), point.position, point.normal, sigma))
                sigma = *own;
        return coverage_ * sigma;
    }

    static void set_arc_lengths(std::vector<ContourPoint>& points) {
        for (std::size_t i = 1; i < points.size(); ++i)
            points[i].arc_length_mm =
                points[i - 1].arc_length_mm + (points[i].position_mm - points[i - 1].position_mm).norm();
    }

    const SmoothCurve& smooth_;
    std::span<const Vec2> good_;
    const SectionOptions& options_;
    SectionFit& fit_;
    std::span<const SurfaceStation> surface_;
    CurveNoise::Walk noise_;
    std::vector<Gap> gaps_;
    std::vector<EdgePatch> patches_;
    double coverage_ = 2.0;
};

}  // namespace

void SurfaceStation::doubt(double ball_radius_mm, double lean_error_rad) {
    const double lean = std::abs(lean_rad);
    offset_error_mm = lean_doubt_mm = lean_error(ball_radius_mm, lean).in_plane_mm;
    if (std::isfinite(lean_error_rad))
        lean_doubt_mm = lean_error(ball_radius_mm, lean + lean_error_rad).in_plane_mm - offset_error_mm;
}

core::Result<OpenEdges> build_contour(const SmoothCurve& smooth, std::span<const Vec2> good,
                                      const SectionOptions& options, SectionFit& fit,
                                      std::span<const SurfaceStation> surface) {
    return ContourBuilder(smooth, good, options, fit, surface).run();
}

}  // namespace cmm::fitting
