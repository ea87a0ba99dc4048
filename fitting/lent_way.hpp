// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "fitting/closed_curve.hpp"
#include "fitting/plane_motion.hpp"
#include "fitting/smoothing.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// The way of a ball round a nominal section, laid onto measured ball centres: what a curve may be supposed to do where
/// nobody measured. A value; the nominal must outlive it.
class LentWay {
  public:
    /// How the points run round the nominal.
    enum class Sense { counter_clockwise, clockwise };

    /// `points`: good ball centres in order, two at least; stretches may be missing between them. They are laid onto
    /// the places of the way that run as they do, by steps of Gauss and Newton along its normals, damped where the
    /// points do not determine one (a straight side alone: along it).
    LentWay(const ClosedCurve& nominal, double ball_radius_mm, std::span<const Vec2> points,
            Sense sense = Sense::counter_clockwise);

    /// How little this is where the points lie: how far they were carried, and 20 times (rms) what is left. The wrong
    /// sense carries them to the other side of the blade (4 mm and more for a ball of 1 mm), where a long stretch fits
    /// badly, too.
    double misfit_mm() const { return misfit_mm_; }
    /// Places between `from` and `to`, counter-clockwise, on the way, bent so that it begins and ends at both; each as
    /// uncertain as a quarter of the step to it.
    std::vector<SupposedPoint> between(const Vec2& from, const Vec2& to) const;

  private:
    struct Place {
        Vec2 centre, normal;
    };
    struct Mark {
        Vec2 centre, along;  // of a measured ball, and where it went
    };

    static std::vector<Mark> marks_of(std::span<const Vec2> points, Sense sense);
    const Place& nearest(const Mark& mark) const;
    void lay_onto(std::span<const Mark> marks);
    Vec2 place_at(double s_mm) const;

    const ClosedCurve* nominal_;
    double ball_radius_mm_;
    std::vector<Place> places_;
    PlaneMotion motion_;  // carries the nominal to where the points lie
    double misfit_mm_ = 0.0;
};

}  // namespace cmm::fitting
