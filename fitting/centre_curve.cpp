// SPDX-License-Identifier: Apache-2.0
#include "fitting/centre_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "core/text.hpp"
#include "fitting/closed_smoothing.hpp"
#include "fitting/closest_point.hpp"
#include "fitting/cyclic.hpp"
#include "fitting/edge_fit.hpp"
#include "fitting/edges_by_conics.hpp"
#include "fitting/gaps.hpp"
#include "fitting/ordering.hpp"
#include "fitting/outliers.hpp"
#include "fitting/stretch_ends.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr double reject_share = 1.5;  // of the threshold: the curve may be off where the sampling is sparse
constexpr double restore_sigmas =
    3.0;  // of the noise: so near to the curve a point that its neighbours accused is good
constexpr double same_centre_mm = 1e-6;
constexpr double clear_share = 1.5;        // of the threshold: above it the good neighbours' word stands
constexpr int most_rounds = 3;             // of fit, reject, restore
constexpr std::size_t trimmed_points = 6;  // beside a gap
constexpr double trim_sigmas = 6.0;        // of the noise: the curve does not follow them
constexpr double most_bad_share = 0.2;
constexpr int most_cuts = 4;              // tangles are cut so often
constexpr double turning_back_rad = 2.2;  // from one step to the next
constexpr std::size_t longest_loop = 14;  // points

/// The lap with its fit and everything derived from it on the way to the curve.
class CentreFitter {
  public:
    CentreFitter(std::span<const Vec2> centres, std::span<const RejectReason> excluded, std::span<const char> kept,
                 std::span<const char> later, const SectionOptions& options)
        : centres_(centres), later_(later), options_(options) {
        fit_.verdicts.resize(centres.size());
        for (std::size_t i = 0; i < std::min(centres.size(), excluded.size()); ++i)
            fit_.verdicts[i].reason = excluded[i];
        for (std::size_t i = 0; i < std::min(centres.size(), kept.size()); ++i)
            fit_.verdicts[i].kept = kept[i] != 0 && fit_.verdicts[i].reason == RejectReason::none;
    }

    core::Result<CentreCurve> run() {
        if (auto status = order(); !status) return tl::unexpected(status.error());
        if (auto status = fit_curve(); !status) return tl::unexpected(status.error());
        tell_edges();
        if (hear_edges()) tell_edges();
        write_verdicts();
        fit_.smooth = std::move(smooth_);
        fit_.good = std::move(good_);
        return std::move(fit_);
    }

  private:
    core::Status order() {
        std::vector<char> excluded(centres_.size(), 0), duplicate;
        for (std::size_t i = 0; i < centres_.size(); ++i) {
            if (!is_finite(centres_[i]) && fit_.verdicts[i].reason == RejectReason::none)
                fit_.verdicts[i].reason = RejectReason::no_contact;
            excluded[i] = fit_.verdicts[i].reason != RejectReason::none;
        }
        std::map<char, std::vector<std::size_t>> later;  // by pass
        for (std::size_t i = 0; i < std::min(centres_.size(), later_.size()); ++i) {
            if (later_[i] == 0 || excluded[i] != 0) continue;
            excluded[i] = 1;  // from the lap
            later[later_[i]].push_back(i);
        }
        const auto usable = usable_points(centres_, excluded, duplicate);
        // A point on the spot of its predecessor tells nothing; one beside it is judged by the curve, like an overlap.
        std::vector<std::size_t> beside;
        const Vec2* before = nullptr;
        for (std::size_t i = 0; i < centres_.size(); ++i) {
            if (duplicate[i] && before && (centres_[i] - *before).norm() > same_centre_mm) {
                beside.push_back(i);
            } else if (duplicate[i]) {
                fit_.verdicts[i].reason = RejectReason::duplicate;
            } else if (!excluded[i]) {
                before = &centres_[i];
            }
        }
        auto lap = order_lap(centres_, usable, options_);
        if (!lap) return tl::unexpected(lap.error());
        for (const auto& [pass, of_pass] : later)
            join_pass(centres_, of_pass, options_.reject_floor_mm, *lap);
        index_ = std::move(lap->index);
        again_ = std::move(lap->again);
        again_.insert(again_.end(), beside.begin(), beside.end());
        for (const std::size_t i : index_)
            points_.push_back(centres_[i]);
        return {};
    }

    core::Status fit_curve() {
        BadPoints found = find_bad_points(points_, true, options_.reject_floor_mm);
        if (static_cast<double>(found.count) > most_bad_share * static_cast<double>(points_.size()) - 1.0)
            return core::fail(ErrorCode::fit_not_evaluable,
                              "section: too many points disagree with their neighbours (" +
                                  std::to_string(found.count) + " of " + std::to_string(points_.size()) + ")");
        residual_ = found.residual;
        threshold_ = found.threshold_mm;
        reason_.assign(points_.size(), RejectReason::none);
        take_verdicts(found);
        hear_beside_gaps(found);
        core::Status turns;
        for (int cuts = 0; cuts < most_cuts; ++cuts) {
            if (auto status = fit_rounds(found, cuts); !status) return status;
            turns = check_turning();
            if (turns || !cut_tangles()) break;
        }
        if (!turns) return turns;
        return {};
    }

    void take_verdicts(const BadPoints& found) {
        for (std::size_t k = 0; k < points_.size(); ++k)
            reason_[k] =
                found.bad[k] && !fit_.verdicts[index_[k]].kept ? RejectReason::spline_residual : RejectReason::none;
    }

    void hear_beside_gaps(BadPoints& found) {
        collect_good_points();
        bool any = false;
        for (const Gap& gap : find_gaps(good_, options_))
            if (!gap.on_side())
                any = judge_ends(points_, fitted_[gap.before], fitted_[gap.behind], options_.reject_floor_mm, found) ||
                      any;
        if (any) take_verdicts(found);
    }

    /// Fit, reject, restore, until nothing changes. After a tangle was cut, verdicts stand.
    core::Status fit_rounds(const BadPoints& found, int cuts) {
        for (int round = 0; round < most_rounds; ++round) {
            collect_good_points();
            auto gaps = find_gaps(good_, options_);
            for (Gap& gap : gaps)
                gap.bad = cyclic(fitted_[gap.behind] + points_.size() - fitted_[gap.before], points_.size()) - 1;
            has_gaps_ = !gaps.empty();
            auto bridges = bridges_over(good_, gaps, options_);
            if (!bridges) return tl::unexpected(std::move(bridges.error()));
            fit_.missing = std::move(bridges->missing);
            auto smooth = smoothing_.run(good_, bridges->over);
            if (!smooth) return tl::unexpected(smooth.error());
            smooth_ = std::move(*smooth);
            if (cuts > 0) break;
            const bool revised = revise_verdicts(found), survived = round == 0 && set_aside_survivors(found.sigma_mm);
            const bool trimmed = trim_beside(gaps, found.sigma_mm);
            if (!revised && !survived && !trimmed) break;
        }
        return {};
    }

    /// The edges as a whole know where they end, better than the curve: then its joints are placed once more.
    void tell_edges() {
        fit_.with_edges.reset();
        if (smooth_.sigma_mm < least_noise_mm || has_gaps_) return;
        const auto told = edges_by_conics(smooth_, good_, options_.ball_radius_mm);
        if (told.empty()) return;
        auto with_edges = smoothing_.with(told);
        if (with_edges && with_edges->joints.size() >= smooth_.joints.size()) fit_.with_edges = std::move(*with_edges);
    }

    /// Good points that their neighbours accused with bad ones beside a joint come back: those that the curve with told
    /// edges bears out, if the curve through them does so as well. False when there are none.
    bool hear_edges() {
        if (!fit_.with_edges) return false;
        const std::vector<RejectReason> before = reason_;
        std::size_t good = 0;
        for (std::size_t k = 0; k < points_.size(); ++k) {
            if (reason_[k] == RejectReason::none)
                ++good;
            else if (reason_[k] == RejectReason::spline_residual && bears_out(*fit_.with_edges, good, points_[k]))
                reason_[k] = RejectReason::none;
        }
        if (reason_ == before) return false;
        bool stands = fit_good_points();
        const std::vector<RejectReason> heard = reason_;
        for (std::size_t i = 0; i < fitted_.size(); ++i)
            if (!stands || std::abs(smooth_.residual[i]) >
                               restore_sigmas * smooth_.sigma_mm * std::sqrt(1.0 - smooth_.leverage[i]))
                reason_[fitted_[i]] = before[fitted_[i]];
        if (reason_ != heard) stands = fit_good_points();
        if (stands) return true;
        reason_ = before;
        return fit_good_points();
    }

    /// False when that is no section.
    bool fit_good_points() {
        collect_good_points();
        auto smooth = smoothing_.run(good_);
        if (!smooth) return false;
        smooth_ = std::move(*smooth);
        for (std::size_t i = 0; i < fitted_.size(); ++i)
            residual_[fitted_[i]] = smooth_.residual[i];
        return check_turning().has_value();
    }

    /// Beside a gap a bad point has no neighbours beyond, and the curve may follow it: where it does so badly, the
    /// points from the gap on to there are set aside. False when there is none.
    bool trim_beside(std::span<const Gap> gaps, double sigma_mm) {
        const std::size_t n = fitted_.size();
        bool any = false;
        for (const Gap& gap : gaps)
            for (const auto& [first, stride] : {std::pair{gap.before, n - 1}, std::pair{gap.behind, std::size_t{1}}}) {
                std::size_t count = 0;
                for (std::size_t i = 0; i < trimmed_points; ++i)
                    if (std::abs(smooth_.residual[(first + i * stride) % n]) > trim_sigmas * sigma_mm) count = i + 1;
                for (std::size_t i = 0; i < count; ++i) {
                    const std::size_t k = fitted_[(first + i * stride) % n];
                    if (fit_.verdicts[index_[k]].kept || reason_[k] != RejectReason::none) continue;
                    reason_[k] = RejectReason::fit_residual;
                    any = true;
                }
            }
        return any;
    }

    /// A good point between two bad ones on the same side of the curve has nobody to bear it out, and the curve may
    /// follow it alone: it has to lie on the curve that the others give. Where that is, its leverage says: without it,
    /// its residual is r / (1 - h) (Cook, Weisberg 1982). False when there is none that does not.
    bool set_aside_survivors(double sigma_mm) {
        const std::size_t n = points_.size();
        bool any = false;
        for (std::size_t i = 0; i < fitted_.size(); ++i) {
            const std::size_t k = fitted_[i], before = cyclic(k + n - 1, n), after = cyclic(k + 1, n);
            if (reason_[k] != RejectReason::none || fit_.verdicts[index_[k]].kept) continue;
            if (reason_[before] != RejectReason::spline_residual || reason_[after] != RejectReason::spline_residual ||
                residual_[before] * residual_[after] <= 0.0)
                continue;
            if (std::abs(smooth_.residual[i]) <= restore_sigmas * sigma_mm * (1.0 - smooth_.leverage[i])) continue;
            reason_[k] = RejectReason::fit_residual;
            any = true;
        }
        return any;
    }

    /// Where the points themselves run back and forth (a ball that fell from one flank of a sharp hollow to the other),
    /// the order of measurement is not the order on the curve: points that turn back on the spot and short loops are
    /// set aside. False when there is nothing of the kind.
    bool cut_tangles() {
        std::vector<std::size_t> at;  // lap positions of the fitted points
        for (std::size_t k = 0; k < points_.size(); ++k)
            if (reason_[k] == RejectReason::none) at.push_back(k);
        const std::size_t n = at.size();
        const auto point = [&](std::size_t i) -> const Vec2& { return points_[at[i % n]]; };
        std::vector<char> cut(n, 0);
        for (std::size_t i = 0; i < n; ++i) {
            const Vec2 in = point(i + 1) - point(i), out = point(i + 2) - point(i + 1);
            if (std::abs(turn_angle(in, out)) > turning_back_rad) cut[(i + 1) % n] = 1;
            for (std::size_t j = i + 2; j < i + longest_loop; ++j) {
                if (!segments_cross(point(i), point(i + 1), point(j), point(j + 1))) continue;
                for (std::size_t k = i + 1; k <= j; ++k)
                    cut[k % n] = 1;
                break;
            }
        }
        bool any = false;
        for (std::size_t i = 0; i < n; ++i) {
            if (!cut[i] || fit_.verdicts[index_[at[i]]].kept) continue;
            reason_[at[i]] = RejectReason::fit_residual;
            any = true;
        }
        return any;
    }

    static bool segments_cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
        const double c_side = cross(b - a, c - a), d_side = cross(b - a, d - a);
        const double a_side = cross(d - c, a - c), b_side = cross(d - c, b - c);
        return c_side * d_side < 0.0 && a_side * b_side < 0.0;
    }

    void collect_good_points() {
        good_.clear();
        fitted_.clear();
        for (std::size_t k = 0; k < points_.size(); ++k) {
            if (reason_[k] != RejectReason::none) continue;
            good_.push_back(points_[k]);
            fitted_.push_back(k);
        }
    }

    /// Checks every point against the fitted curve (A9): what the neighbours excused is rejected, good points that bad
    /// neighbours accused come back. False when nothing changed.
    bool revise_verdicts(const BadPoints& found) {
        bool changed = false;
        std::size_t good = 0;
        for (std::size_t k = 0; k < points_.size(); ++k) {
            if (reason_[k] == RejectReason::none) {
                residual_[k] = smooth_.residual[good];
                const bool far_off = !found.corner[k] && std::abs(residual_[k]) > reject_share * found.threshold_mm[k];
                const std::size_t at = good++;
                if (!far_off || fit_.verdicts[index_[k]].kept || std::abs(residual_[k]) <= 4.0 * misfit_near(at))
                    continue;
                reason_[k] = RejectReason::fit_residual;
                changed = true;
            } else {
                residual_[k] = distance_between(good, points_[k]);
                // No curve is a witness against clear neighbours.
                const bool clear = std::abs(found.residual[k]) > clear_share * found.threshold_mm[k];
                if (clear || std::abs(residual_[k]) > restore_sigmas * found.sigma_mm) continue;
                reason_[k] = RejectReason::none;
                changed = true;
            }
        }
        return changed;
    }

    /// Median of the residuals' magnitude among five neighbours on each side of a good point: where the curve itself
    /// does not follow the part, no single point is to blame.
    double misfit_near(std::size_t i) const {
        const std::vector<double>& r = smooth_.residual;
        std::array<double, 11> near{};
        for (std::size_t k = 0; k < near.size(); ++k)
            near[k] = std::abs(r[(i + r.size() + k - 5) % r.size()]);
        std::nth_element(near.begin(), near.begin() + 5, near.end());
        return near[5];
    }

    /// Signed distance of a point that is not in the fit, searched from the nearer of its good neighbours, the
    /// `behind`-th good point and the one before: between them may be a gap.
    double distance_between(std::size_t behind, const Vec2& p) const {
        const Jet jet = smooth_.curve.jet(foot_between(smooth_, behind, p));
        return std::copysign((p - jet.position).norm(), (p - jet.position).dot(jet.right_normal()));
    }
    /// Whether such a point is as near to a curve as the noise of both allows.
    bool bears_out(const SmoothCurve& smooth, std::size_t behind, const Vec2& p) const {
        const double t = smooth.curve.wrap(foot_between(smooth, behind, p));
        const double distance = (p - smooth.curve.jet(t).position).norm();
        return distance <= restore_sigmas * std::hypot(smooth.sigma_mm, smooth.noise.sigma_mm(t));
    }
    double foot_between(const SmoothCurve& smooth, std::size_t behind, const Vec2& p) const {
        const PiecewiseCubic& curve = smooth.curve;
        const std::size_t n = good_.size(), after = behind % n, before = (behind + n - 1) % n;
        const bool is_before = (good_[before] - p).squaredNorm() <= (good_[after] - p).squaredNorm();
        double t = smooth.parameter[is_before ? before : after];
        for (int step = 0; step < 10; ++step) {
            const Jet jet = curve.jet(t);
            const double move = (p - jet.position).dot(jet.d1) / std::max(jet.d1.squaredNorm(), 1e-12);
            t += std::clamp(move, -0.02 * curve.period(), 0.02 * curve.period());
            if (std::abs(move) < 1e-9 * curve.period()) break;
        }
        return t;
    }

    /// A closed curve without crossings turns once (Hopf's Umlaufsatz).
    core::Status check_turning() const {
        double turned = 0.0;
        const auto& breaks = smooth_.curve.breaks();
        Vec2 last = smooth_.curve.pieces().front()[1];
        for (std::size_t k = 0; k < smooth_.curve.spans(); ++k) {
            for (int part = 1; part <= 4; ++part) {
                const Vec2 now = smooth_.curve.jet_in(k, breaks[k] + 0.25 * part * (breaks[k + 1] - breaks[k])).d1;
                turned += turn_angle(last, now);
                last = now;
            }
        }
        if (std::abs(turned - 2.0 * std::numbers::pi) < 0.5) return {};
        return core::fail(ErrorCode::fit_not_evaluable,
                          "section: the curve of ball centres crosses itself (it turns by " +
                              core::fixed(turned * 180.0 / std::numbers::pi, 0) + " degrees, not 360)");
    }

    void write_verdicts() {
        for (std::size_t k = 0; k < points_.size(); ++k)
            fit_.verdicts[index_[k]] = {reason_[k], residual_[k], fit_.verdicts[index_[k]].kept};
        judge_overlap();
        fit_.rejected = static_cast<std::size_t>(std::count_if(
            fit_.verdicts.begin(), fit_.verdicts.end(), [](const auto& v) { return v.reason != RejectReason::none; }));
    }

    /// The overlap of the scan is judged by the curve that its first measurement gave, as strictly as the points there.
    void judge_overlap() {
        if (again_.empty()) return;
        std::vector<double> threshold;  // by fitted point
        for (std::size_t k = 0; k < points_.size(); ++k)
            if (reason_[k] == RejectReason::none) threshold.push_back(threshold_[k]);
        const ClosestPointIndex index(smooth_.curve);
        std::size_t span = 0;
        for (const std::size_t i : again_) {
            const CurveFoot foot = index.closest(centres_[i], span);
            span = foot.span;
            const Vec2 outward = smooth_.curve.jet(foot.t).right_normal();
            const double residual =
                std::copysign(std::sqrt(foot.squared), (centres_[i] - smooth_.curve.jet(foot.t).position).dot(outward));
            const auto next = std::lower_bound(smooth_.parameter.begin(), smooth_.parameter.end(), foot.t);
            const std::size_t at = static_cast<std::size_t>(next - smooth_.parameter.begin()) % threshold.size();
            PointVerdict& verdict = fit_.verdicts[i];
            verdict.residual_mm = residual;
            if (!verdict.kept && std::abs(residual) > std::max(reject_share * threshold[at], 4.0 * misfit_near(at)))
                verdict.reason = RejectReason::fit_residual;
        }
    }

    CentreCurve fit_;
    std::span<const Vec2> centres_;
    std::span<const char> later_;
    const SectionOptions& options_;
    std::vector<std::size_t> index_;  // lap position -> input index
    std::vector<std::size_t> again_;  // input indices of the overlap
    std::vector<Vec2> points_;        // by lap position, like the next two
    std::vector<RejectReason> reason_;
    std::vector<double> residual_, threshold_;
    std::vector<Vec2> good_;           // the points that smooth_ was fitted to
    std::vector<std::size_t> fitted_;  // their lap positions
    bool has_gaps_ = false;            // they have
    ClosedSmoothing smoothing_;
    SmoothCurve smooth_;
};

}  // namespace

core::Result<CentreCurve> fit_centre_curve(std::span<const Vec2> centres, std::span<const RejectReason> excluded,
                                           const SectionOptions& options, std::span<const char> kept,
                                           std::span<const char> later) {
    return CentreFitter(centres, excluded, kept, later, options).run();
}

}  // namespace cmm::fitting
