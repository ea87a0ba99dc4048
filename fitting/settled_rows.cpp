// SPDX-License-Identifier: Apache-2.0
#include "fitting/settled_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/common_moves.hpp"
#include "fitting/knot_spacing.hpp"
#include "fitting/known_fit.hpp"
#include "fitting/row_alignment.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t common_anchors = 1600;
/// Points without noise bear finer knots than rows have use for in common: with these their errors are the same.
constexpr double least_knot_sigma_mm = 6e-5;
/// However well the others foretell a joint, it may lie off them by so much.
constexpr double least_joint_sigma_mm = 0.005;
constexpr double least_known = 0.05;  // share of a knot's jump that all rows tell
/// Of the rows: where fewer tell anything of a knot, it is smooth. One with a dent tells a lot, and may be the only
/// one.
constexpr double telling_share = 0.25;
constexpr double least_told_square = 1e-14;
constexpr double beside_share = 0.5;  // that a knot's neighbours have in its roughness
constexpr double freedom = 4.0;       // of Student's distribution, by which a row's jump is of the common scale
constexpr int scale_updates = 3;
constexpr double most_jump_squares = 100.0;  // of the common ones: a jump by ten standard deviations
constexpr double median_of_square = 0.4549;  // of a normal variable of variance 1
/// The first with known roughness: without, the curve bends half-way to a few bad points.
constexpr int judged_round = 1;
/// That what the rows have in common may take a curve from where its own points have it: by chance it does by two
/// standard deviations of a point, where a few bad points were not found by eight.
constexpr double most_strayed_sigmas = 10.0, least_strayed_mm = 5e-3;
/// Of the row's own curve: where its points tell it badly, the others may well tell it better.
constexpr double most_strayed_doubts = 4.0;
constexpr int rounds_a_move = 3;           // at the end, of all rows together
constexpr std::size_t rows_that_tell = 6;  // how rough it is at a knot; fewer have their joints alone in common

/// What rows have in common, along u from where they begin: half-way along a side, where there are no joints.
class CommonShape {
  public:
    explicit CommonShape(std::span<const SurfaceRow> rows)
        : rows_(rows), features_(features_of(rows)), alignment_(features_) {
        begin_u_ = 0.5 * (alignment_.place(RowFeatures::le_end) + alignment_.place(RowFeatures::te_begin));
        for (std::size_t k = 0; k < rows.size(); ++k) {
            begin_mm_.push_back(s_at(k, 0.0));
            begin_t_.push_back(rows[k].parameter(begin_mm_[k]));
        }
        place_knots();
    }

    double begin_mm(std::size_t row) const { return begin_mm_[row]; }
    double begin_t(std::size_t row) const { return begin_t_[row]; }

    KnownShape on(std::size_t row) const {
        KnownShape shape;
        for (const double u : knots_)
            shape.breaks.push_back(parameter(row, s_at(row, u)));
        shape.breaks.front() = 0.0;
        shape.breaks.back() = rows_[row].smooth().curve.period();
        shape.joints = joints_on(row);
        shape.roughness = roughness_;
        shape.roughness_doubt = std::exp(1.0 / static_cast<double>(rows_.size()));
        return shape;
    }

    std::vector<KnownJoint> joints_on(std::size_t row) const {
        std::vector<KnownJoint> joints;
        for (const auto& joint : alignment_.joints_on(row))
            joints.push_back({parameter(row, joint.s_mm), joint.step, std::max(joint.sigma_mm, least_joint_sigma_mm)});
        std::sort(joints.begin(), joints.end(), [](const KnownJoint& a, const KnownJoint& b) { return a.t < b.t; });
        return joints;
    }

    /// What a row's points said of its joints, and, when it was fitted with the common shape, of its roughness.
    void hear_joints(std::size_t row, const KnownFit& fit) {
        std::vector<RowJoint> joints;
        for (const CurvatureStep& joint : fit.joints())
            joints.push_back({rows_[row].arc_length(joint.told_t + begin_t_[row]), joint.told_sigma_mm, joint.step});
        features_[row].set_joints(joints);
    }
    void hear_roughness(const KnownFit& fit, const KnownShape& shape) { heard_.push_back(fit.roughness(shape)); }

    /// From what was heard since the last time.
    void learn() {
        alignment_ = RowAlignment(features_);
        const std::size_t n = knots_.size() - 1;
        roughness_.resize(n);
        for (std::size_t i = 0; i < n; ++i)
            roughness_[i] = common_roughness(i);
        heard_.clear();
    }

  private:
    /// What each row says of the roughness at a knot and, for less, beside it.
    struct Told {
        KnotRoughness of;
        double share;
    };
    void hear_at(std::size_t i) {
        const std::size_t n = knots_.size() - 1, before = (i + n - 1) % n, behind = (i + 1) % n;
        const bool begins = joint_behind(before), ends = joint_behind(i);
        told_.clear();
        for (const auto& heard : heard_) {
            told_.push_back({heard[i], 1.0});
            if (!begins) told_.push_back({heard[before], beside_share});
            if (!ends) told_.push_back({heard[behind], beside_share});
        }
    }

    /// The scale of Student's distribution that is likeliest by all rows (West 1984): one that has a bad point there,
    /// which makes its jump far larger than the others', hardly counts, and one that has a dent does not.
    double common_roughness(std::size_t i) {
        hear_at(i);
        double scale = usual_roughness(i);
        for (int update = 0; update < scale_updates; ++update) {
            KnotRoughness sum{least_told_square, least_known};
            for (const auto& [of, share] : told_) {
                if (of.square > most_jump_squares * of.known * scale) continue;
                sum.square += share * (freedom + of.known) * of.square * scale / (freedom * scale + of.square);
                sum.known += share * of.known;
            }
            scale = sum.square / sum.known;
        }
        return scale;
    }

    double usual_roughness(std::size_t i) {
        single_.clear();
        for (const auto& heard : heard_)
            if (heard[i].known > least_known) single_.push_back(heard[i].square / heard[i].known);
        if (single_.empty() || static_cast<double>(single_.size()) < telling_share * static_cast<double>(heard_.size()))
            return least_told_square;
        return std::max(nth_smallest(single_, single_.size() / 2) / median_of_square, least_told_square);
    }

    double s_at(std::size_t row, double u) const {
        const double period = alignment_.period(), at = begin_u_ + u;
        return alignment_.arc_length(row, at < period ? at : at - period);
    }

    /// From where the row begins.
    double parameter(std::size_t row, double s_mm) const {
        const double period = rows_[row].smooth().curve.period();
        const double t = rows_[row].parameter(s_mm) - begin_t_[row];
        return t - period * std::floor(t / period);
    }

    void place_knots() {
        const double period = alignment_.period();
        const std::size_t usual = usual_row(rows_);
        std::vector<double> u(common_anchors);
        std::vector<Vec2> anchors(common_anchors);
        for (std::size_t i = 0; i < common_anchors; ++i) {
            u[i] = period * static_cast<double>(i) / static_cast<double>(common_anchors);
            anchors[i] = rows_[usual].at(s_at(usual, u[i]));
        }
        std::vector<double> sigma;
        for (const SurfaceRow& row : rows_)
            sigma.push_back(row.smooth().sigma_mm);
        const double noise = std::max(nth_smallest(sigma, sigma.size() / 2), least_knot_sigma_mm);
        knots_ = graded_knots(anchors, u, period, span_turn(noise), most_spans);
    }

    bool joint_behind(std::size_t knot) const {
        const double period = alignment_.period();
        return std::any_of(alignment_.joints().begin(), alignment_.joints().end(), [&](double joint) {
            const double u = joint < begin_u_ ? joint - begin_u_ + period : joint - begin_u_;
            return u > knots_[knot] && u < knots_[knot + 1];
        });
    }

    std::span<const SurfaceRow> rows_;
    std::vector<RowFeatures> features_;
    RowAlignment alignment_;
    double begin_u_ = 0.0;
    std::vector<double> begin_mm_, begin_t_;  // by row
    std::vector<double> knots_;               // u from there
    std::vector<double> roughness_;
    std::vector<std::vector<KnotRoughness>> heard_;  // of each row, at each knot
    std::vector<Told> told_;                         // at the knot in question
    std::vector<double> single_;
};

/// Whether a settled curve, which begins at `begin_t` of the row's own, is elsewhere than it: at or between its breaks.
bool strays(const PiecewiseCubic& settled, const SmoothCurve& own, double begin_t) {
    const double most = std::max(most_strayed_sigmas * own.sigma_mm, least_strayed_mm);
    std::size_t near = 0;
    const auto strays_at = [&](std::size_t span, double t) {
        double own_t = own.curve.wrap(t + begin_t);
        near = own.curve.span_of(own_t, near);
        const Jet jet = settled.jet_in(span, t);
        const double strayed_mm = std::abs(cross(jet.tangent(), own.curve.jet_in(near, own_t).position - jet.position));
        return strayed_mm > most && strayed_mm > most_strayed_doubts * own.noise.sigma_mm(own_t);
    };
    const std::vector<double>& breaks = settled.breaks();
    for (std::size_t i = 0; i < settled.spans(); ++i)
        if (strays_at(i, breaks[i]) || strays_at(i, 0.5 * (breaks[i] + breaks[i + 1]))) return true;
    return false;
}

/// A row on its way.
struct SettlingRow {
    KnownFit fit;
    bool alike = true;  // it has the common shape
    bool known = true;  // it bears the common joints
};

}  // namespace

std::vector<SurfaceRow> settle_rows(std::span<const SurfaceRow> rows, int rounds) {
    if (rows.size() < 2) return {rows.begin(), rows.end()};
    CommonShape common(rows);
    std::vector<SettlingRow> settling;
    for (std::size_t k = 0; k < rows.size(); ++k)
        settling.push_back({KnownFit(rows[k].smooth(), common.begin_t(k)), rows.size() >= rows_that_tell});
    for (int round = 0; round < rounds; ++round) {
        if (round > 0) common.learn();
        for (std::size_t k = 0; k < rows.size(); ++k) {
            auto& [fit, alike, known] = settling[k];
            if (alike) {
                const KnownShape shape = common.on(k);
                alike = fit.fit(shape) && (round != judged_round || fit.follows());
                if (alike)
                    common.hear_roughness(fit, shape);
                else
                    fit = KnownFit(rows[k].smooth(), common.begin_t(k));
            }
            if (!alike && known)
                known = fit.fit({own_breaks(rows[k].smooth(), common.begin_t(k)), common.joints_on(k), {}}).has_value();
            if (known) common.hear_joints(k, fit);
        }
    }
    std::vector<KnownFit*> alike;
    for (SettlingRow& row : settling)
        if (row.alike) alike.push_back(&row.fit);
    move_together(alike, (rounds + 1) / rounds_a_move, rows_that_tell);
    std::vector<SurfaceRow> settled;
    settled.reserve(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
        settled.push_back(rows[k]);
        if (!settling[k].known) continue;
        SmoothCurve smooth = std::move(settling[k].fit).finish();
        if (!strays(smooth.curve, rows[k].smooth(), common.begin_t(k)))
            settled.back() = rows[k].with(std::move(smooth), common.begin_mm(k));
    }
    return settled;
}

}  // namespace cmm::fitting
