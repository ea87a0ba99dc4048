// SPDX-License-Identifier: Apache-2.0
#include "fitting/smoothing_joints.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fitting/curvature_joints.hpp"

namespace cmm::fitting {
namespace {

constexpr int joint_tunings = 3, last_tunings = 2;
constexpr int most_shifts = 4;  // of the joints
constexpr std::size_t knots_of_joint = 3;
constexpr double knot_share = 0.02;  // of a span: how near they are
constexpr double place_grid_mm = 1e-3;
constexpr double least_joint_speed = 0.3, most_joint_turn_rad = 0.2;
constexpr double most_curve_variance = 16.0;   // at a joint, over that of a point
constexpr double most_control_variance = 4.0;  // over the largest of the curve without joints
constexpr double told_square = 8.0;            // of a step that no ramp shows, over its variance
constexpr double lasting_step_share = 0.2;     // of the ramp's
constexpr double far_shift_sigmas = 2.0;       // of a joint's shift: the step of the curvature times its square
constexpr std::size_t clear_spans = 3;         // from a known joint to the next, and to where the curve begins
constexpr double most_known_shift = 2.0;       // of a known joint, over what its place is known to

/// A joint's place is known to some hundredths of a millimetre: what rounding does to it must not move the curve.
double on_grid(double t) {
    return std::round(t / place_grid_mm) * place_grid_mm;
}

double largest_variance_mm2(const SmoothingSystem& system) {
    double largest = 0.0;
    for (std::size_t k = 0; k < system.spans(); ++k)
        largest = std::max(largest, system.control_variance(k));
    return system.sigma_mm() * system.sigma_mm() * largest;
}

/// The curvature may jump by any step between the first and the last knot; a joint elsewhere by d turns the tangent by
/// step d: the change of slope at the middle knot is 2 step d / apart^2.
void free_joint(Roughness& roughness, const KnotCluster& knots, double step, double elsewhere_mm) {
    const auto& [first, apart] = knots;
    const double turn = 2.0 * step * elsewhere_mm / (apart * apart * std::sqrt(apart));
    roughness.hold(first - 1, std::numeric_limits<double>::infinity());
    roughness.hold(first, turn * turn);
    roughness.hold(first + 1, std::numeric_limits<double>::infinity());
}

/// What the curve says of a joint whose knots are `apart`.
struct SeenJoint {
    double step = 0.0;   // of the curvature
    double shift = 0.0;  // from there to where the tangents of both sides agree
};
SeenJoint seen_at(const PiecewiseCubic& curve, double t, double apart) {
    const double before = curve.jet(t - apart).curvature(), behind = curve.jet(t + apart).curvature();
    const double turn = apart * (curve.jet(t).curvature() - 0.5 * (before + behind));
    return {behind - before, -turn / (behind - before)};
}

/// The breaks but for those of the joints.
std::vector<double> breaks_without(const std::vector<double>& breaks, std::span<const KnotCluster> joints) {
    std::vector<double> plain;
    std::size_t next = 0;
    const auto copy_to = [&](std::size_t end) {
        plain.insert(plain.end(), breaks.begin() + static_cast<std::ptrdiff_t>(next),
                     breaks.begin() + static_cast<std::ptrdiff_t>(end));
    };
    for (const KnotCluster& joint : joints) {
        copy_to(joint.first);
        next = joint.first + knots_of_joint;
    }
    copy_to(breaks.size());
    return plain;
}

/// One try with given joints.
class Placement {
  public:
    Placement(SmoothingSystem& system, std::vector<CurvatureJoint> joints, double most_variance_mm2)
        : system_(system), joints_(std::move(joints)), most_variance_mm2_(most_variance_mm2) {
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
    const std::vector<char>& refuted() const { return refuted_; }

  private:
    bool open(const std::vector<double>& plain, const std::vector<Roughness::Run>& ramps) {
        std::vector<double> places;
        for (const CurvatureJoint& joint : joints_)
            places.push_back(joint.t);
        if (!system_.change_breaks(breaks_with_joints(plain, places, knots_of_joint, knot_share, knots_), ramps))
            return false;
        for (std::size_t j = 0; j < joints_.size(); ++j)
            free_joint(system_.roughness(), knots_[j], joints_[j].step, 0.5 * joints_[j].width_mm);
        return true;
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
            if (!is_known(j)) refuted_[j] = 1;
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

    /// Whether the points tell the curve there.
    bool is_known(std::size_t j) const {
        return system_.variance(knots_[j].first, system_.basis(knots_[j].first).at(1.0)) < most_curve_variance;
    }

    /// Whether its step is more than what the noise makes.
    bool is_told(std::size_t j) const {
        const double t = joints_[j].t, apart = knots_[j].apart, step = step_at(j);
        return step * step > told_square * system_.step_variance(t - apart, t + apart);
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
        const std::vector<double> plain = breaks_without(system_.breaks(), knots_);
        strayed_ = false;
        for (std::size_t j = 0; j < joints_.size(); ++j) {
            CurvatureJoint& joint = joints_[j];
            const SeenJoint seen = seen_at(system_.curve(), joint.t, knots_[j].apart);
            const double most = 0.5 * joint.width_mm, last = joint.t;
            joint.step = seen.step;
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
    bool strayed_ = false;  // in the latest shift, so far that another one follows
};

/// Whether joints in order leave each other, and the curve's beginning, their knots.
bool have_room(std::span<const CurvatureStep> joints, std::span<const double> breaks) {
    const auto breaks_below = [&](double t) {
        return static_cast<std::size_t>(std::lower_bound(breaks.begin(), breaks.end(), t) - breaks.begin());
    };
    std::size_t before = 0;
    for (const CurvatureStep& joint : joints) {
        const std::size_t below = breaks_below(joint.t);
        if (below < before + clear_spans) return false;
        before = below;
    }
    return before + clear_spans <= breaks.size();
}

}  // namespace

core::Result<std::vector<CurvatureStep>> place_joints(SmoothingSystem& system) {
    system.measure_jumps();
    auto joints = find_curvature_joints(system.breaks(), system.slopes(), system.lengths_mm(), system.sigma_mm());
    add_supposed_joints(system.breaks(), system.slopes(), system.lengths_mm(), system.sigma_mm(), joints);
    for (CurvatureJoint& joint : joints)
        joint.t = on_grid(joint.t);
    const auto plain = joints.empty() ? SmoothingSystem::State() : system.state();
    const double most_variance_mm2 = most_control_variance * largest_variance_mm2(system);
    while (!joints.empty()) {
        Placement placement(system, joints, most_variance_mm2);
        if (placement.run()) {
            std::vector<CurvatureStep> steps;
            for (const CurvatureJoint& joint : placement.joints())
                steps.push_back({joint.t, joint.step});
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

core::Result<std::vector<CurvatureStep>> fit_with_joints(SmoothingSystem& system, std::span<const double> breaks,
                                                         std::span<const double> t, std::span<const KnownJoint> joints,
                                                         int tunings) {
    std::vector<CurvatureStep> steps;
    std::vector<KnotCluster> knots;
    const auto with_knots = [&](std::span<const double> plain) {
        std::vector<double> places;
        for (const CurvatureStep& step : steps)
            places.push_back(step.t);
        return breaks_with_joints(plain, places, knots_of_joint, knot_share, knots);
    };
    const auto no_room = [] {
        return core::fail(core::ErrorCode::fit_not_evaluable,
                          "smoothing spline: a joint of the curvature is too near to another, or to where the curve "
                          "begins");
    };
    const auto refine = [&](int count) {
        for (std::size_t j = 0; j < joints.size(); ++j)
            free_joint(system.roughness(), knots[j], steps[j].step, joints[j].sigma_mm);
        return system.refine(count);
    };
    for (const KnownJoint& joint : joints)
        steps.push_back({on_grid(joint.t), joint.step});
    if (!have_room(steps, breaks)) return no_room();
    if (auto status = system.start(with_knots(breaks), t); !status) return tl::unexpected(status.error());
    if (auto status = refine(tunings); !status) return tl::unexpected(status.error());
    const std::vector<double> plain = breaks_without(system.breaks(), knots);
    for (std::size_t j = 0; j < joints.size(); ++j) {
        const SeenJoint seen = seen_at(system.curve(), steps[j].t, knots[j].apart);
        const double most = most_known_shift * joints[j].sigma_mm;
        steps[j] = {on_grid(joints[j].t + std::clamp(steps[j].t + seen.shift - joints[j].t, -most, most)), seen.step};
    }
    if (!have_room(steps, plain)) return no_room();
    if (auto status = system.change_breaks(with_knots(plain), {}); !status) return tl::unexpected(status.error());
    if (auto status = refine(joint_tunings); !status) return tl::unexpected(status.error());
    system.measure();
    return steps;
}

std::vector<double> breaks_without_joints(const SmoothCurve& smooth) {
    std::vector<double> plain = smooth.curve.breaks();
    for (const CurvatureStep& joint : smooth.joints) {
        const auto above = std::upper_bound(plain.begin() + 1, plain.end() - 1, joint.t);
        const auto middle = joint.t - above[-1] < *above - joint.t ? above - 1 : above;
        if (middle - plain.begin() < 2 || plain.end() - middle < 3) continue;
        plain.erase(middle + 1);
        plain.erase(middle - 1);
    }
    return plain;
}

}  // namespace cmm::fitting
