// SPDX-License-Identifier: Apache-2.0
#include "fitting/live_hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cmm::fitting {
namespace {

/// A jump of the curvature, by what it typically turns a step, and the logarithm of its probability.
struct Jump {
    double turn_rad, log_probability;
};
constexpr std::array<Jump, 2> jumps{{{0.1, -5.0}, {0.4, -7.0}}};  // one sample in 150 and in 1100
constexpr double log_bad = -4.4;                                  // one sample in 100, anywhere within 0.8 mm: per mm
constexpr double log_start = -7.0;           // one bad sample in 1000 is none, but a corner or a lost way
constexpr double start_turn_variance = 0.1;  // of the heading against the first chord, rad^2
constexpr double negligible = -9.2;          // 1e-4 of the best
constexpr std::uint32_t recent_bad = 0x3f, recent_jump = 0xf;  // where hypotheses must differ

double log_normal(double residual, double variance) {
    return -0.5 * (residual * residual / variance + std::log(2.0 * std::numbers::pi * variance));
}

/// Roughness of a step on which the curvature jumps at an unknown place.
double jump_rate(const Jump& jump, double length) {
    const double l = std::max(std::abs(length), 1e-9);
    return jump.turn_rad * jump.turn_rad / (l * l * l);
}

/// A curve of which a chord is known.
Hypothesis from_chord(const Vec2& anchor, const Vec2& centre, double noise) {
    const Vec2 chord = centre - anchor;
    const double length = chord.norm(), curvature = jumps.back().turn_rad / length;
    Hypothesis first;
    first.counting = 2;
    first.length_mm = length;
    first.state.position = centre;
    first.state.tangent = chord / length;
    first.state.covariance.dd = noise;
    first.state.covariance.ss = start_turn_variance + 2.0 * noise / (length * length);
    first.state.covariance.cc = curvature * curvature;
    return first;
}

/// The curve goes on to a sample that counts.
void take_in(Hypothesis& to, const Hypothesis& from, const ArcFoot& foot, const Vec2& centre, double noise,
             double rate) {
    to.foot = foot;
    to.predicted = carried_covariance(from.state, foot, rate);
    const ArcUpdate update = updated(from.state, foot, centre, to.predicted, noise);
    to.state = update.state;
    to.correction = update.correction;
    ++to.counting;
    to.length_mm += foot.length;
    to.turned_rad += foot.turn + to.correction[1];
}

}  // namespace

void Hypotheses::begin(const Vec2& anchor, const Vec2& centre, double noise) {
    all_[0] = from_chord(anchor, centre, noise);
    size_ = 1;
}

void Hypotheses::carry(const Hypotheses& before) {
    size_ = before.size_;
    for (std::size_t h = 0; h < size_; ++h) {
        all_[h] = before.all_[h];
        all_[h].role = SampleRole::skipped;
        all_[h].parent = static_cast<std::uint8_t>(h);
        all_[h].bad_bits <<= 1U;
        all_[h].jump_bits <<= 1U;
    }
}

void Hypotheses::extend(const Hypotheses& before, const Vec2& anchor, const Vec2& centre,
                        const LiveEvidence& evidence) {
    Candidates candidates;
    std::array<ArcFoot, width> feet;  // of the sample on each curve so far
    for (std::size_t h = 0; h < before.size_; ++h)
        feet[h] = foot_on_arc(before.all_[h].state, centre);
    const std::size_t n = before.propose(candidates, feet, evidence);
    std::sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(n),
              [](const Candidate& a, const Candidate& b) {
                  if (a.weight != b.weight) return a.weight > b.weight;
                  return a.parent != b.parent ? a.parent < b.parent : a.role < b.role;
              });
    size_ = 0;
    const double best = candidates[0].weight;
    for (std::size_t i = 0; i < n && size_ < width && candidates[i].weight >= best + negligible; ++i) {
        Candidate c = candidates[i];
        const bool known =
            std::any_of(all_.begin(), all_.begin() + static_cast<std::ptrdiff_t>(size_), [&](const Hypothesis& other) {
                return ((other.bad_bits ^ c.bad_bits) & recent_bad) == 0 &&
                       ((other.jump_bits ^ c.jump_bits) & recent_jump) == 0;
            });
        if (known) continue;
        c.weight -= best;
        append(c, before.all_[c.parent], feet[c.parent], anchor, centre, evidence);
    }
}

/// The probability of each continuation: of the one before, of what it supposes, and of the sample's place.
std::size_t Hypotheses::propose(Candidates& candidates, std::span<const ArcFoot> feet,
                                const LiveEvidence& evidence) const {
    std::size_t n = 0;
    double best = -std::numeric_limits<double>::infinity();
    const auto offer = [&](double weight, std::size_t h, SampleRole role, double rate = 0.0) {
        if (!(weight >= best + negligible)) return;
        best = std::max(best, weight);
        const Hypothesis& from = all_[h];
        const std::uint32_t bad = role == SampleRole::bad ? 1U : 0U;
        const std::uint32_t jump = role == SampleRole::jump || role == SampleRole::start ? 1U : 0U;
        candidates[n++] = {weight, (from.bad_bits << 1U) | bad,  (from.jump_bits << 1U) | jump,
                           rate,   static_cast<std::uint8_t>(h), role};
    };
    for (std::size_t h = 0; h < size_; ++h) {
        const Hypothesis& from = all_[h];
        const ArcFoot& foot = feet[h];
        if (foot.reached) {
            const double variance = carried_variance(from.state, foot) + evidence.noise();
            const auto offer_with = [&](double log_probability, SampleRole role, double rate) {
                const double spread = variance + process_variance(rate, foot.length);
                offer(from.weight + log_probability + log_normal(foot.offset, spread), h, role, rate);
            };
            offer_with(0.0, SampleRole::good, evidence.roughness());
            for (const Jump& jump : jumps)
                offer_with(jump.log_probability, SampleRole::jump, jump_rate(jump, foot.length));
        }
        offer(from.weight + log_bad, h, SampleRole::bad);
        if (from.role == SampleRole::bad) offer(from.weight + log_bad + log_start, h, SampleRole::start);
    }
    return n;
}

void Hypotheses::append(const Candidate& candidate, const Hypothesis& from, const ArcFoot& foot, const Vec2& anchor,
                        const Vec2& centre, const LiveEvidence& evidence) {
    Hypothesis& to = all_[size_++];
    if (candidate.role == SampleRole::start) {
        to = from_chord(anchor, centre, evidence.noise());
        to.turned_rad = from.turned_rad + turn_angle(from.state.tangent, to.state.tangent);
        to.length_mm += from.length_mm;
    } else {
        to.counting = from.counting;
        to.length_mm = from.length_mm;
        to.turned_rad = from.turned_rad;
        to.gain_known = false;
    }
    to.role = candidate.role;
    to.parent = candidate.parent;
    to.weight = candidate.weight;
    to.bad_bits = candidate.bad_bits;
    to.jump_bits = candidate.jump_bits;
    if (candidate.role == SampleRole::bad) to.state = from.state;
    if (candidate.role == SampleRole::good || candidate.role == SampleRole::jump)
        take_in(to, from, foot, centre, evidence.noise(), candidate.rate);
}

Hypotheses::Across Hypotheses::across(const Vec2& place, double roughness) const {
    double sum = 0.0, mean = 0.0, square = 0.0;
    for (std::size_t h = 0; h < size_; ++h) {
        const ArcFoot foot = foot_on_arc(all_[h].state, place);
        if (!foot.reached) continue;
        double rate = roughness;
        for (const Jump& jump : jumps)
            rate += std::exp(jump.log_probability) * jump_rate(jump, foot.length);
        const double variance = carried_variance(all_[h].state, foot) + process_variance(rate, foot.length);
        const double weight = std::exp(all_[h].weight);
        sum += weight;
        mean -= weight * foot.offset;
        square += weight * (variance + foot.offset * foot.offset);
    }
    if (!(sum > 0.0)) return {};
    mean /= sum;
    return {mean, std::max(square / sum - mean * mean, 0.0)};
}

}  // namespace cmm::fitting
