// SPDX-License-Identifier: Apache-2.0
#include "fitting/live_spline.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cmm::fitting {
namespace {

constexpr double no_way_mm = 1e-7;
constexpr double farthest_mm = 1e6;          // no machine is that large
constexpr double live_anchor_sigmas = 8.0;   // length of the chord from which a curve begins
constexpr std::uint32_t least_counting = 3;  // samples
constexpr double missing_turn_rad = 0.7;     // of a lap: what bad samples may hide at its two ends

}  // namespace

MaterialSide material_side(const Vec2& outward_normal, const Vec2& travel) {
    return right_normal(travel).dot(outward_normal) >= 0.0 ? MaterialSide::left : MaterialSide::right;
}

LiveSpline::LiveSpline(MaterialSide side) : side_(side == MaterialSide::left ? 1.0 : -1.0), ring_(ring_size) {}

LiveSpline::Taken LiveSpline::add(std::uint64_t sequence, const Vec2& centre, bool excluded) {
    const std::size_t first = taken_ > depth ? taken_ - depth : 0;
    std::size_t at = taken_;
    while (at > first && slot(at - 1).sequence > sequence)
        --at;
    if (at > 0 && slot(at - 1).sequence == sequence) return Taken::repeated;
    if (at > 0 && slot(at - 1).sequence > sequence) return Taken::stale;
    for (std::size_t i = taken_; i > at; --i) {
        Slot& to = slot(i);
        const Slot& from = slot(i - 1);
        to.sequence = from.sequence;
        to.centre = from.centre;
        to.usable = from.usable;
    }
    Slot& now = slot(at);
    now.sequence = sequence;
    now.centre = centre;
    now.usable = !excluded && centre.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= farthest_mm;
    ++taken_;
    for (std::size_t i = at; i < taken_; ++i)
        reckon(i);
    return at + 1 == taken_ ? Taken::newest : Taken::late;
}

/// All that is known after a sample from what was known before it.
void LiveSpline::reckon(std::size_t index) {
    Slot& now = slot(index);
    now.hypotheses.clear();
    now.evidence = {};
    now.closing = {};
    in_window_ = 0;
    if (index == 0) return;
    const Slot& before = slot(index - 1);
    now.evidence = before.evidence;
    now.closing = before.closing;
    const Vec2* anchor = now.usable ? anchor_of(index) : nullptr;
    if (anchor == nullptr) {
        now.hypotheses.carry(before.hypotheses);
    } else if (before.hypotheses.empty()) {
        now.hypotheses.begin(*anchor, now.centre, now.evidence.noise());
    } else {
        now.hypotheses.extend(before.hypotheses, *anchor, now.centre, now.evidence);
    }
    if (now.hypotheses.empty()) return;
    smooth(index);
    learn(now.evidence);
    follow_closing(now);
}

/// The newest earlier centre that is clearly farther away than the noise, or else the farthest one back; nullptr when
/// there is none, or the predecessor is at the same place.
const Vec2* LiveSpline::anchor_of(std::size_t index) const {
    const Slot& now = slot(index);
    const double apart = live_anchor_sigmas * std::sqrt(now.evidence.noise());
    const Vec2* found = nullptr;
    for (std::size_t back = 1; back <= std::min(index, depth); ++back) {
        const Slot& other = slot(index - back);
        if (!other.usable) continue;
        const double distance = (other.centre - now.centre).norm();
        if (distance <= no_way_mm) {
            if (found == nullptr) return nullptr;
            continue;
        }
        found = &other.centre;
        if (distance >= apart) break;
    }
    return found;
}

/// Back-substitution through the window along the best account (Rauch, Tung, Striebel 1965).
void LiveSpline::smooth(std::size_t index) {
    in_window_ = 0;
    std::size_t h = 0;
    Triple by{};
    Symmetric3 covariance = slot(index).hypotheses[0].state.covariance;
    for (std::size_t back = 0; back <= std::min(lag, index); ++back) {
        Hypothesis& at = slot(index - back).hypotheses[h];
        window_[in_window_++] = {&at, by, covariance};
        if (index == back || slot(index - back - 1).hypotheses.empty()) return;
        h = at.parent;
        const Hypothesis& from = slot(index - back - 1).hypotheses[h];
        if (at.role == SampleRole::start) {
            by = {};
            covariance = from.state.covariance;
        } else if (at.role == SampleRole::good || at.role == SampleRole::jump) {
            if (!at.gain_known) at.gain = backward_gain(from.state, at.foot, at.predicted);
            at.gain_known = true;
            const Triple& u = at.correction;
            by = product(at.gain, {u[0] + by[0], u[1] + by[1], u[2] + by[2]});
            covariance = smoothed_covariance(from.state.covariance, at.gain, covariance, at.predicted);
        }
    }
}

/// Noise and roughness from the sample that leaves the window.
void LiveSpline::learn(LiveEvidence& evidence) const {
    if (in_window_ <= lag) return;
    const Smoothed &older = window_[lag], &newer = window_[lag - 1];
    const Hypothesis &from = *older.at, &to = *newer.at;
    const double leverage = older.covariance.dd / evidence.noise();
    if (from.role == SampleRole::good || from.role == SampleRole::jump)
        evidence.learn_residual(from.foot.offset - from.correction[0] - older.by[0], leverage);
    if (to.role != SampleRole::good) return;
    const double change = to.state.curvature + newer.by[2] - from.state.curvature - older.by[2];
    const Triple& g = to.gain[2];
    const Symmetric3& p = newer.covariance;
    const double common = g[0] * p.dc + g[1] * p.sc + g[2] * p.cc;
    evidence.learn_change(change, p.cc + older.covariance.cc - 2.0 * common, std::abs(to.foot.length));
}

void LiveSpline::follow_closing(Slot& now) const {
    Closing& closing = now.closing;
    if (in_window_ <= lag) return;
    if (!closing.known) {
        // A lap begins where the curve has come to be sure, not at bad first samples.
        const Smoothed& first = window_[lag];
        const bool sure = first.at->role == SampleRole::good &&
                          std::none_of(window_.begin(), window_.end(),
                                       [](const Smoothed& s) { return s.at->role == SampleRole::start; });
        if (!sure) return;
        const ArcState start = displaced(first.at->state, first.by);
        closing = {true,
                   start.position,
                   start.tangent,
                   now.hypotheses[0].state.position,
                   first.at->turned_rad,
                   closing.lateral_mm};
        return;
    }
    const Hypothesis& best = now.hypotheses[0];
    const Vec2 before = closing.before - closing.start, after = best.state.position - closing.start;
    closing.before = best.state.position;
    if (side_ * (best.turned_rad - closing.turned_rad) < 2.0 * std::numbers::pi - missing_turn_rad) return;
    if (before.dot(closing.tangent) > 0.0 || after.dot(closing.tangent) <= 0.0) return;
    closing.lateral_mm = std::min(
        {closing.lateral_mm, std::abs(cross(closing.tangent, before)), std::abs(cross(closing.tangent, after))});
}

bool LiveSpline::ready() const {
    return in_window_ > 0 && window_[0].at->counting >= least_counting;
}

LiveSpline::Point LiveSpline::point(std::size_t back) const {
    Point out;
    if (back >= in_window_) return out;
    const Slot& sample = slot(taken_ - 1 - back);
    const Smoothed& smoothed = window_[back];
    ArcState state = displaced(smoothed.at->state, smoothed.by);
    state.covariance = smoothed.covariance;
    out.doubtful = smoothed.at->role == SampleRole::bad;
    out.skipped = smoothed.at->role == SampleRole::skipped;
    double variance = smoothed.covariance.dd;
    if (const ArcFoot foot = foot_on_arc(state, sample.centre); out.doubtful && foot.reached) {
        variance = carried_variance(state, foot) + process_variance(sample.evidence.roughness(), foot.length);
        state.position = sample.centre - foot.offset * left_of(foot.tangent);
        state.tangent = foot.tangent;
    }
    if (back == 0) {
        const auto all = sample.hypotheses.across(state.position, sample.evidence.roughness());
        variance = all.variance + all.mean * all.mean;
    }
    out.valid = smoothed.at->counting >= least_counting;
    out.sequence = sample.sequence;
    out.position = state.position;
    out.tangent = state.tangent;
    out.normal = side_ * right_normal(state.tangent);
    out.curvature = side_ * state.curvature;
    out.sigma_mm = std::sqrt(std::max(variance, 0.0));
    return out;
}

LiveSpline::Prediction LiveSpline::predict(double step_mm) const {
    if (!ready()) return {};
    const Slot& now = last();
    const Hypothesis& best = now.hypotheses[0];
    // A sample that does not count has not moved the state: the next one lies beyond it.
    const ArcFoot newest = foot_on_arc(best.state, now.centre);
    const double ahead = step_mm + (best.role == SampleRole::bad && newest.reached ? newest.length : 0.0);
    const double turn = best.state.curvature * ahead;
    // sin(x)/x and (1 - cos(x))/x of the arc; the series keeps straight lines exact.
    const bool straight = std::abs(turn) < 1e-6;
    const double forward = straight ? 1.0 : std::sin(turn) / turn;
    const double leftward = straight ? 0.5 * turn : (1.0 - std::cos(turn)) / turn;
    const Vec2 &along = best.state.tangent, left = left_of(along);
    const Vec2 centre = best.state.position + ahead * (forward * along + leftward * left);
    const Vec2 tangent = std::cos(turn) * along + std::sin(turn) * left;
    const auto all = now.hypotheses.across(centre, now.evidence.roughness());
    return {true, centre + all.mean * left_of(tangent), side_ * right_normal(tangent),
            std::sqrt(all.variance + now.evidence.noise())};
}

double LiveSpline::suggest_step(double min_mm, double max_mm, double chord_error_mm) const {
    // Nothing known, or the newest sample disagrees: it is bad or the part turns, the next one must be near to tell.
    const Point now = newest();
    if (!now.valid || now.doubtful) return min_mm;
    const double kappa = std::abs(now.curvature);
    if (kappa * max_mm * max_mm <= 8.0 * chord_error_mm) return max_mm;
    return std::clamp(std::sqrt(8.0 * chord_error_mm / kappa), min_mm, max_mm);
}

double LiveSpline::noise_mm() const {
    return std::sqrt(taken_ > 0 ? last().evidence.noise() : LiveEvidence().noise());
}

double LiveSpline::length_mm() const {
    return ready() ? window_[0].at->length_mm : 0.0;
}

double LiveSpline::turned_rad() const {
    return ready() ? side_ * window_[0].at->turned_rad : 0.0;
}

bool LiveSpline::closed(double lateral_tolerance_mm) const {
    return taken_ > 0 && last().closing.lateral_mm <= lateral_tolerance_mm;
}

}  // namespace cmm::fitting
