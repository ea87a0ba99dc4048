// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fitting/arc_state.hpp"
#include "fitting/live_evidence.hpp"

namespace cmm::fitting {

/// What the newest sample is held to be.
enum class SampleRole : std::uint8_t {
    start,    ///< the curve begins here, from the chord to an earlier sample
    good,     ///< on the curve
    jump,     ///< on the curve, whose curvature has jumped since the sample before
    bad,      ///< does not count
    skipped,  ///< was never to count
};

/// One account of the samples so far, and the curve that follows from it.
struct Hypothesis {
    SampleRole role = SampleRole::start;
    std::uint8_t parent = 0;     ///< which hypothesis of the sample before it continues
    std::uint32_t counting = 0;  ///< samples that count
    std::uint32_t bad_bits = 0;  ///< samples held to be bad, newest in the lowest bit
    std::uint32_t jump_bits = 0;
    double weight = 0.0;  ///< logarithm of the probability over that of the best
    double length_mm = 0.0, turned_rad = 0.0;
    ArcState state;        ///< at the foot of the newest sample that counts
    Symmetric3 predicted;  ///< covariance there before that sample; this and the rest for good and jump
    Triple correction{};   ///< of the state by the sample
    ArcFoot foot;          ///< of the sample on the arc of the parent's state
    Matrix3 gain{};        ///< of the backward step, once it is known
    bool gain_known = false;
};

/// The most probable accounts of the samples up to one of them, best first: which are bad, and where the curvature
/// jumps, is told apart by the samples that follow (docs/theory.md, section 9). A value of constant size; millimetres.
class Hypotheses {
  public:
    static constexpr std::size_t width = 8;

    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    const Hypothesis& operator[](std::size_t i) const { return all_[i]; }
    Hypothesis& operator[](std::size_t i) { return all_[i]; }

    void clear() { size_ = 0; }
    /// A curve from `anchor` to `centre`, of which nothing else is known.
    void begin(const Vec2& anchor, const Vec2& centre, double noise);
    /// The sample does not count.
    void carry(const Hypotheses& before);
    /// Every account so far goes on in up to four ways: the sample is good, or good after a jump of the curvature, or
    /// bad, or (after a bad one) the start of a curve from `anchor`. The most probable are kept; of those that differ
    /// long ago only, one.
    void extend(const Hypotheses& before, const Vec2& anchor, const Vec2& centre, const LiveEvidence& evidence);

    /// What all together say of the curve's place across its path there, relative to `place` and to the left: mean and
    /// variance, mm and mm^2.
    struct Across {
        double mean = 0.0, variance = 0.0;
    };
    Across across(const Vec2& place, double roughness) const;

  private:
    struct Candidate {
        double weight;
        std::uint32_t bad_bits, jump_bits;
        double rate;  // roughness of the step
        std::uint8_t parent;
        SampleRole role;
    };
    using Candidates = std::array<Candidate, 5 * width>;

    std::size_t propose(Candidates& candidates, std::span<const ArcFoot> feet, const LiveEvidence& evidence) const;
    void append(const Candidate& candidate, const Hypothesis& from, const ArcFoot& foot, const Vec2& anchor,
                const Vec2& centre, const LiveEvidence& evidence);

    std::size_t size_ = 0;
    std::array<Hypothesis, width> all_;
};

}  // namespace cmm::fitting
