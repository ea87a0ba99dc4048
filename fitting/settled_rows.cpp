// SPDX-License-Identifier: Apache-2.0
#include "fitting/settled_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/knot_spacing.hpp"
#include "fitting/known_fit.hpp"
#include "fitting/row_alignment.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t common_anchors = 1600;
/// However well the others foretell a joint, it may lie off them by so much.
constexpr double least_joint_sigma_mm = 0.005;
constexpr double least_known = 0.05;  // share of a knot's jump that all rows tell
constexpr double least_told_square = 1e-14;
constexpr double beside_share = 0.5;  // that a knot's neighbours have in its roughness
constexpr double freedom = 4.0;       // of Student's distribution, by which a row's jump is of the common scale
constexpr int scale_updates = 3;
/// The first with known roughness: without, the curve bends half-way to a few bad points.
constexpr int judged_round = 1;
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
    /// The scale of Student's distribution that is likeliest by all rows (West 1984): one that has a dent there or a
    /// bad point, which makes its jump far larger than the others', hardly counts.
    double common_roughness(std::size_t i) const {
        const std::size_t n = knots_.size() - 1, before = (i + n - 1) % n, behind = (i + 1) % n;
        const double of_before = joint_behind(before) ? 0.0 : beside_share;
        const double of_behind = joint_behind(i) ? 0.0 : beside_share;
        double scale = 0.0;
        for (int update = 0; update <= scale_updates; ++update) {
            KnotRoughness sum{least_told_square, least_known};
            const auto add = [&](const KnotRoughness& told, double share) {
                const double weight = update == 0 ? 1.0 : (freedom + told.known) / (freedom + told.square / scale);
                sum.square += share * weight * told.square;
                sum.known += share * told.known;
            };
            for (const auto& told : heard_) {
                add(told[i], 1.0);
                add(told[before], of_before);
                add(told[behind], of_behind);
            }
            scale = sum.square / sum.known;
        }
        return scale;
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
        const std::size_t middle = rows_.size() / 2;
        std::vector<double> u(common_anchors);
        std::vector<Vec2> anchors(common_anchors);
        for (std::size_t i = 0; i < common_anchors; ++i) {
            u[i] = period * static_cast<double>(i) / static_cast<double>(common_anchors);
            anchors[i] = rows_[middle].at(s_at(middle, u[i]));
        }
        std::vector<double> sigma;
        for (const SurfaceRow& row : rows_)
            sigma.push_back(row.smooth().sigma_mm);
        knots_ = graded_knots(anchors, u, period, span_turn(nth_smallest(sigma, sigma.size() / 2)), most_spans);
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
};

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
    std::vector<SurfaceRow> settled;
    settled.reserve(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k)
        settled.push_back(settling[k].known ? rows[k].with(std::move(settling[k].fit).finish(), common.begin_mm(k))
                                            : rows[k]);
    return settled;
}

}  // namespace cmm::fitting
