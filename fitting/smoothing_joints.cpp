// SPDX-License-Identifier: Apache-2.0
#include "fitting/smoothing_joints.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fitting/curvature_joints.hpp"
#include "fitting/joint_knots.hpp"

namespace cmm::fitting {
namespace {

constexpr int joint_tunings = 3, last_tunings = 2;
constexpr int most_shifts = 4;  // of the joints
constexpr double least_joint_speed = 0.3, most_joint_turn_rad = 0.2;
constexpr double most_curve_variance = 16.0;   // at a joint, over that of a point
constexpr double most_control_variance = 4.0;  // over the largest of the curve without joints
constexpr double told_square = 8.0;            // of a step, over its variance
constexpr double lasting_step_share = 0.2;     // of the ramp's
constexpr double far_shift_sigmas = 2.0;       // of a joint's shift: the step of the curvature times its square

bool has_told_place(const CurvatureJoint& joint) {
    return joint.told_sigma_mm > 0.0;
}

CurvatureJoint without_ramp(const ToldJoint& told, const std::vector<double>& breaks) {
    const auto above = std::upper_bound(breaks.begin(), breaks.end(), told.t) - breaks.begin();
    const auto span = static_cast<std::size_t>(above) - 1;
    CurvatureJoint joint;
    joint.step = joint.ramp_step = told.step;
    joint.width_mm = breaks[span + 1] - breaks[span];
    joint.first_span = span - 1;
    joint.last_span = span + 1;
    return joint;
}

/// A joint that is told is where it is told, if it has room there; others in its way are none.
void put(const ToldJoint& told, const std::vector<double>& breaks, std::vector<CurvatureJoint>& joints) {
    constexpr double far = std::numeric_limits<double>::infinity();
    const auto clear = [&](double t) { return have_room(std::min(t, told.t), std::max(t, told.t), breaks); };
    const auto in_its_way = [&](const CurvatureJoint& joint) { return !clear(joint.t); };
    if (!clear(-far) || !clear(far)) return;
    auto its = joints.end();
    double nearest = told.reach_mm;
    for (auto joint = joints.begin(); joint != joints.end(); ++joint) {
        if (has_told_place(*joint) && in_its_way(*joint)) return;
        const double off = std::abs(joint->t - told.t);
        if (has_told_place(*joint) || joint->step * told.step < 0.0 || off > nearest) continue;
        nearest = off;
        its = joint;
    }
    CurvatureJoint joint = its != joints.end() ? *its : without_ramp(told, breaks);
    joint.t = told.t;
    joint.told_sigma_mm = told.sigma_mm;
    if (its != joints.end()) joints.erase(its);
    std::erase_if(joints, in_its_way);
    joints.push_back(joint);
}

void put_told_ones(std::span<const ToldEdge> told, const SmoothingSystem& system, std::vector<CurvatureJoint>& joints) {
    for (const ToldEdge& edge : told)
        for (const ToldJoint& joint : {edge.begin, edge.end})
            put(joint, system.breaks(), joints);
    std::sort(joints.begin(), joints.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
}

/// One try with given joints.
class Placement {
  public:
    Placement(SmoothingSystem& system, std::vector<CurvatureJoint> joints, double most_variance_mm2,
              std::span<const ToldEdge> told)
        : system_(system), joints_(std::move(joints)), most_variance_mm2_(most_variance_mm2), told_(told) {
        refuted_.assign(joints_.size(), 0);
    }

    /// False when the points refute a joint, or do not determine the system.
    bool run() {
        std::vector<Roughness::Run> ramps;  // the roughness of a ramp is no roughness of the curve
        for (const CurvatureJoint& joint : joints_)
            ramps.push_back({joint.first_span - 1, joint.last_span});
        if (!open(system_.breaks(), ramps)) return false;
        for (int shift = 0;; ++shift) {
            if (!system_.refine(joint_tunings) || !stand()) return false;
            if (shift == most_shifts || (shift > 0 && !strayed_)) break;
            if (!shift_all()) return false;
        }
        system_.measure();
        return are_known();
    }

    const std::vector<CurvatureJoint>& joints() const { return joints_; }
    void tell_places(std::vector<CurvatureStep>& steps) const {
        for (std::size_t j = 0; j < steps.size(); ++j)
            tell_place(system_, knots_[j], steps[j].step, steps[j]);
    }
    const std::vector<char>& refuted() const { return refuted_; }

  private:
    bool open(const std::vector<double>& plain, const std::vector<Roughness::Run>& ramps) {
        std::vector<double> places;
        for (const CurvatureJoint& joint : joints_)
            places.push_back(joint.t);
        if (!system_.change_breaks(with_joint_knots(plain, places, knots_), ramps)) return false;
        for (std::size_t j = 0; j < joints_.size(); ++j) {
            const CurvatureJoint& joint = joints_[j];
            const double sigma_mm = has_told_place(joint) ? joint.told_sigma_mm : 0.5 * joint.width_mm;
            free_joint(system_, knots_[j], joint.step, sigma_mm);
        }
        for (const ToldEdge& edge : told_)
            if (is_at(edge.begin) && is_at(edge.end)) expect(edge);
        return true;
    }

    bool is_at(const ToldJoint& told) const {
        const double t = on_grid(told.t);
        return std::any_of(joints_.begin(), joints_.end(),
                           [&](const CurvatureJoint& joint) { return has_told_place(joint) && joint.t == t; });
    }

    /// Between its joints the curvature changes as it is told.
    void expect(const ToldEdge& edge) {
        const auto& breaks = system_.breaks();
        const double period = system_.curve().period();
        const auto ahead = [&](double t) { return t < edge.begin.t ? t - edge.begin.t + period : t - edge.begin.t; };
        const auto slope = [&](std::size_t span) {
            return (edge.curvature(breaks[span + 1]) - edge.curvature(breaks[span])) / system_.lengths_mm()[span];
        };
        for (std::size_t k = 0; k < system_.spans(); ++k) {
            if (ahead(breaks[k + 1]) > ahead(edge.end.t) || system_.roughness().held(k)) continue;
            const double turn = slope(k + 1 < system_.spans() ? k + 1 : 0) - slope(k);
            system_.expect_jump(k, turn / std::sqrt(system_.mean_length_mm(k)));
        }
    }

    bool none_refuted() const {
        return std::none_of(refuted_.begin(), refuted_.end(), [](char refuted) { return refuted != 0; });
    }

    bool stand() {
        for (std::size_t j = 0; j < joints_.size(); ++j)
            if (turns_back(j) || !lasts(j) || (joints_[j].supposed && !is_told(j))) refuted_[j] = 1;
        return none_refuted();
    }

    bool are_known() {
        for (std::size_t j = 0; j < joints_.size(); ++j)
            if (!is_known(j) || !is_told(j)) refuted_[j] = 1;
        refute_where_uncertain();
        return none_refuted();
    }

    /// Between its knots a curve has no room to turn; where it does all the same, a bad point has it on a leash.
    bool turns_back(std::size_t j) const {
        const Vec2 before = system_.curve().jet(system_.breaks()[knots_[j].first]).d1;
        const Vec2 behind = system_.curve().jet(system_.breaks()[knots_[j].first + 2]).d1;
        const double slower = std::min(before.norm(), behind.norm());
        return !(slower > least_joint_speed) || !(std::abs(turn_angle(before, behind)) < most_joint_turn_rad);
    }

    /// Of the curve there, against that of a point.
    double variance_at(std::size_t j) const {
        return system_.variance(knots_[j].first, system_.basis(knots_[j].first).at(1.0));
    }

    /// Whether the points tell the curve there.
    bool is_known(std::size_t j) const { return variance_at(j) < most_curve_variance; }

    /// Whether its step is more than what the noise makes; where the curve is known less well than a point is, by as
    /// much more: other forms bear out the same points.
    bool is_told(std::size_t j) const {
        const double t = joints_[j].t, apart = knots_[j].apart, step = step_at(j);
        const double least = told_square * std::max(variance_at(j), 1.0);
        return step * step > least * system_.step_variance(t - apart, t + apart);
    }

    /// One whose step has hardly anything of the ramp that it was made from is none.
    bool lasts(std::size_t j) const {
        const double ramp = joints_[j].ramp_step;
        return step_at(j) * ramp >= lasting_step_share * ramp * ramp;
    }

    double step_at(std::size_t j) const {
        const double t = joints_[j].t, apart = knots_[j].apart;
        return system_.curve().jet(t + apart).curvature() - system_.curve().jet(t - apart).curvature();
    }

    /// Joints that make the curve much less certain than it was without them, wherever that is.
    void refute_where_uncertain() {
        const double most = most_variance_mm2_ / (system_.sigma_mm() * system_.sigma_mm());
        for (std::size_t k = 0; k < system_.spans(); ++k)
            if (!(system_.control_variance(k) <= most)) refuted_[nearest(k)] = 1;
    }

    /// The joint that is nearest to a control.
    std::size_t nearest(std::size_t control) const {
        const auto away = [&](std::size_t j) {
            const std::size_t middle = knots_[j].first + 2, n = system_.spans();  // controls weigh the knots before
            const std::size_t apart = control > middle ? control - middle : middle - control;
            return std::min(apart, n - apart);
        };
        std::size_t best = 0;
        for (std::size_t j = 1; j < joints_.size(); ++j)
            if (away(j) < away(best)) best = j;
        return best;
    }

    /// Each joint goes to where the tangents of both sides agree.
    bool shift_all() {
        const std::vector<double> plain = without_joint_knots(system_.breaks(), knots_);
        strayed_ = false;
        for (std::size_t j = 0; j < joints_.size(); ++j) {
            CurvatureJoint& joint = joints_[j];
            const SeenJoint seen = seen_at(system_.curve(), joint.t, knots_[j].apart);
            const double most = 0.5 * joint.width_mm, last = joint.t;
            joint.step = seen.step;
            if (has_told_place(joint)) continue;
            joint.t = on_grid(std::clamp(last + std::clamp(seen.shift, -most, most), joint.from_t, joint.to_t));
            const double shift = joint.t - last;
            if (std::abs(joint.step) * shift * shift > far_shift_sigmas * system_.sigma_mm()) strayed_ = true;
        }
        return open(plain, {});
    }

    SmoothingSystem& system_;
    std::vector<CurvatureJoint> joints_;
    std::vector<char> refuted_;
    std::vector<KnotCluster> knots_;
    double most_variance_mm2_;
    std::span<const ToldEdge> told_;
    bool strayed_ = false;  // in the latest shift, so far that another one follows
};

}  // namespace

core::Result<std::vector<CurvatureStep>> place_joints(SmoothingSystem& system, const SmoothingSystem::State& plain,
                                                      std::span<const ToldEdge> told) {
    system.measure_jumps();
    auto joints = find_curvature_joints(system.breaks(), system.slopes(), system.lengths_mm(), system.sigma_mm());
    add_supposed_joints(system.breaks(), system.slopes(), system.lengths_mm(), system.sigma_mm(), joints);
    std::erase_if(joints, [&](const CurvatureJoint& joint) { return !system.was_measured(joint.t); });
    put_told_ones(told, system, joints);
    for (CurvatureJoint& joint : joints)
        joint.t = on_grid(joint.t);
    const double most_variance_mm2 = most_control_variance * plain.largest_variance_mm2;
    while (!joints.empty()) {
        Placement placement(system, joints, most_variance_mm2, told);
        if (placement.run()) {
            std::vector<CurvatureStep> steps;
            for (const CurvatureJoint& joint : placement.joints())
                steps.push_back({joint.t, joint.step});
            placement.tell_places(steps);
            return steps;
        }
        if (auto status = system.restore(plain); !status) return tl::unexpected(status.error());
        std::vector<CurvatureJoint> left;
        for (std::size_t j = 0; j < joints.size(); ++j)
            if (placement.refuted()[j] == 0) left.push_back(joints[j]);
        if (left.size() == joints.size()) left.clear();  // singular
        joints = std::move(left);
    }
    system.measure();
    if (auto status = system.refine(last_tunings); !status) return tl::unexpected(status.error());
    system.measure();
    return std::vector<CurvatureStep>{};
}

}  // namespace cmm::fitting
