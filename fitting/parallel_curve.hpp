// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fitting/spline.hpp"

namespace cmm::fitting {

/// A point of a parallel curve and where it comes from.
struct OffsetPoint {
    Vec2 position = Vec2::Zero();
    Vec2 normal = Vec2::Zero();  ///< unit, outward
    double t = 0.0;              ///< parameter on the source curve
    bool on_arc = false;         ///< about a corner of the source
};

/// A piece of a parallel curve on which it neither stops nor turns by more than 86 degrees: over part of a piece of
/// the source, or the arc about a corner of the source.
struct Stretch {
    std::size_t span = 0;  ///< piece of the source; of a corner the piece that begins there
    bool about_corner = false;
    bool backwards = false;            ///< runs against the source: inside a loop
    bool left = false, right = false;  ///< the source turns nowhere right; nowhere left; straight: both
    double from = 0.0, to = 0.0;       ///< parameter of the source; about a corner the angle of the normal
    double turn = 0.0;                 ///< bound of the total turning
    Vec2 begin = Vec2::Zero(), end = Vec2::Zero();
    double reach = 0.0;  ///< bound of the distance from the chord begin-end
};

/// The curve p = c + d n parallel to a closed counter-clockwise curve c (n: outward normal; d < 0: inwards), with its
/// loops, and with the arc of radius |d| about every corner of c: closed and continuous. Built as stretches with
/// certified bounds: the turning of a Bezier hodograph is at most that of its control polygon, and an arc that turns by
/// a < pi stays within |begin-end|/2 tan(a/2) of its chord (Schur 1921). Refers to c, which must outlive it.
class ParallelCurve {
  public:
    ParallelCurve(const PiecewiseCubic& source, double distance_mm);

    const std::vector<Stretch>& stretches() const { return stretches_; }
    const PiecewiseCubic& source() const { return source_; }
    double distance() const { return distance_; }
    /// Runs with the source everywhere: no local loops (1 + d kappa > 0).
    bool regular() const { return regular_; }

    /// x between the stretch's from and to (or a little beyond).
    OffsetPoint at(const Stretch& stretch, double x) const;
    Vec2 derivative(const Stretch& stretch, double x) const;
    Stretch part(const Stretch& stretch, double from, double to) const;

  private:
    void add_corner(std::size_t span, const Vec2& before, const Vec2& after);
    void add_piece(std::size_t span);
    void add_part(std::size_t span, double from, double to, bool backwards);
    struct Run {
        double from = 0.0;
        bool backwards = false;
    };
    bool can_halve(std::size_t span, double from, double to) const;
    void find_runs(std::size_t span, double from, double to, std::vector<Run>& runs) const;
    Stretch stretch_of(std::size_t span, double from, double to, bool backwards) const;

    const PiecewiseCubic& source_;
    double distance_ = 0.0;
    bool regular_ = true;
    std::vector<Stretch> stretches_;
};

}  // namespace cmm::fitting
