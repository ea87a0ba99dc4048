// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "fitting/live_hypotheses.hpp"

namespace cmm::fitting {

/// On which side of the travel the material lies: left for a counter-clockwise scan (outward normal to the right).
enum class MaterialSide : std::uint8_t { left, right };

/// The side, from the outward normal at the first touch and the direction of the first move.
MaterialSide material_side(const Vec2& outward_normal, const Vec2& travel);

/// The curve of ball centres while it is scanned: a smoothing spline through the last samples, what it says of the next
/// one, and when the lap closes (docs/theory.md, section 9). `add` costs a constant time and allocates nothing. It
/// holds the last samples only; who keeps the record of the scan can always rebuild it: the same samples, added in any
/// order that `add` calls newest or late, give the same bits. One owner, no locking, millimetres.
class LiveSpline {
  public:
    static constexpr std::size_t lag = 16;    ///< samples behind the newest one whose place later ones still improve
    static constexpr std::size_t depth = 14;  ///< samples by which a late one may have been overtaken

    enum class Taken : std::uint8_t {
        newest,
        late,      ///< put in its place, what follows it reckoned again
        repeated,  ///< that sequence is there already: nothing changes
        stale,     ///< overtaken by more than `depth`: nothing changes
    };

    /// The curve at a sample.
    struct Point {
        bool valid = false;  ///< false below 3 samples that count, and beyond the window
        std::uint64_t sequence = 0;
        Vec2 position = Vec2::Zero();  ///< smoothed centre
        Vec2 tangent = Vec2::UnitX();  ///< unit, direction of travel
        Vec2 normal = Vec2::UnitY();   ///< unit, out of the material
        double curvature = 0.0;        ///< 1/mm, positive where the section is convex
        double sigma_mm = 0.0;         ///< standard uncertainty of the position, across the curve
        bool doubtful = false;         ///< at present the sample counts as bad
        bool skipped = false;          ///< the sample was never to count
    };
    struct Prediction {
        bool valid = false;
        Vec2 centre = Vec2::Zero();
        Vec2 normal = Vec2::UnitY();  ///< out of the material at the predicted centre
        double sigma_mm = 0.0;        ///< standard deviation of the sample across the path, noise included
    };

    explicit LiveSpline(MaterialSide side);
    /// No copies: what is known of the last samples points into itself.
    LiveSpline(const LiveSpline&) = delete;
    LiveSpline& operator=(const LiveSpline&) = delete;
    LiveSpline(LiveSpline&&) = default;
    LiveSpline& operator=(LiveSpline&&) = default;
    ~LiveSpline() = default;

    /// A centre that is excluded (no contact), not finite, or where its predecessor is, keeps its place in the order
    /// but does not count.
    Taken add(std::uint64_t sequence, const Vec2& centre, bool excluded = false);

    Point newest() const { return point(0); }
    /// The curve at the sample `back` before the newest, 0 to `lag`.
    Point point(std::size_t back) const;
    /// The next sample, `step_mm` after the newest one.
    Prediction predict(double step_mm) const;
    /// sqrt(8 e / kappa) (seed 000, A2) within [min, max]: the step whose chord error is e; the least step while the
    /// newest sample is in doubt.
    double suggest_step(double min_mm, double max_mm, double chord_error_mm) const;

    /// Standard deviation of a sample across the curve, as the samples show it.
    double noise_mm() const;
    double length_mm() const;
    /// Angle that the travel has turned since the start, positive towards the material: about +2 pi after one lap.
    double turned_rad() const;
    /// One lap is done: turned about 2 pi and passed the first samples within `lateral_tolerance_mm`.
    bool closed(double lateral_tolerance_mm = 0.5) const;

  private:
    struct Closing {
        bool known = false;  // start and its tangent, turned until there
        Vec2 start = Vec2::Zero(), tangent = Vec2::UnitX(), before = Vec2::Zero();
        double turned_rad = 0.0;
        double lateral_mm = std::numeric_limits<double>::infinity();  // at which the start was passed
    };
    /// A sample and all that was known after it.
    struct Slot {
        std::uint64_t sequence = 0;
        Vec2 centre = Vec2::Zero();
        bool usable = false;
        Hypotheses hypotheses;
        LiveEvidence evidence;
        Closing closing;
    };
    /// A hypothesis of the best account's past, and by how much later samples displace it.
    struct Smoothed {
        const Hypothesis* at = nullptr;
        Triple by{};
        Symmetric3 covariance;
    };
    static constexpr std::size_t ring_size = 32;  // lag and depth, and one sample to either side
    static_assert(ring_size >= lag + depth + 2);

    Slot& slot(std::size_t index) { return ring_[index % ring_size]; }
    const Slot& slot(std::size_t index) const { return ring_[index % ring_size]; }
    const Slot& last() const { return slot(taken_ - 1); }
    bool ready() const;
    void reckon(std::size_t index);
    const Vec2* anchor_of(std::size_t index) const;
    void smooth(std::size_t index);
    void learn(LiveEvidence& evidence) const;
    void follow_closing(Slot& now) const;

    double side_;  // +1: material on the left
    std::vector<Slot> ring_;
    std::size_t taken_ = 0;
    std::array<Smoothed, lag + 1> window_;  // newest first
    std::size_t in_window_ = 0;
};

}  // namespace cmm::fitting
