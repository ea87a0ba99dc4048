// SPDX-License-Identifier: Apache-2.0
#include "sim/contact.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::sim {

namespace {

constexpr double tight_mm = 1e-8;
constexpr double graze_mm = 1e-7;
// Steps are never shorter: what a line can dip into a ball-sized rounding within one is h^2 / 8 r, below the graze
// tolerance.
constexpr double least_step_mm = 1e-3;
constexpr int most_steps = 2000;

/// The gap between ball and surface along a line: f(s) = distance - radius, |f'| <= 1.
class GapLine {
  public:
    struct Value {
        double s, gap, slope;
        Contact contact;
    };

    GapLine(const Surface& surface, const Eigen::Vector3d& start, const Eigen::Vector3d& direction, double radius,
            std::size_t& warm)
        : surface_(surface), start_(start), direction_(direction), radius_(radius), warm_(warm) {}

    Value at(double s) const {
        const Contact contact = surface_.nearest(start_ + s * direction_, warm_);
        return {s, contact.distance_mm - radius_, contact.normal.dot(direction_), contact};
    }
    BallContact ball(const Value& value) const {
        return {start_ + value.s * direction_, value.contact.point, value.contact.normal, value.s};
    }

    /// The root between a free and a touching place: Newton, kept between both, else bisection.
    Value root(Value free, Value touching) const {
        Value best = std::abs(free.gap) < std::abs(touching.gap) ? free : touching;
        for (int i = 0; i < 100 && std::abs(best.gap) > tight_mm; ++i) {
            const double low = std::min(free.s, touching.s), high = std::max(free.s, touching.s);
            double s = best.slope != 0.0 ? best.s - best.gap / best.slope : low;
            if (!(s > low && s < high) || i % 8 == 7) s = 0.5 * (low + high);
            if (s == low || s == high) break;  // neighbours in floating point
            best = at(s);
            (best.gap > 0.0 ? free : touching) = best;
        }
        return best;
    }

    /// From a free place ahead to the first contact. A step as long as the gap cannot pass a contact; up to twice the
    /// gap is safe where the free balls of both ends overlap (Keinert and others 2014, over-relaxed sphere tracing).
    std::optional<Value> forward(Value here, double limit) const {
        for (int i = 0; i < most_steps; ++i) {
            if (here.gap <= graze_mm && here.slope > -1e-3) return here;
            if (here.gap <= tight_mm) return here;
            if (here.s >= limit) return std::nullopt;
            const double newton = here.slope < 0.0 ? -here.gap / here.slope : 2.0 * here.gap;
            double step = std::clamp(newton, here.gap, 2.0 * here.gap);
            Value next = at(std::min(limit, here.s + std::max(step, least_step_mm)));
            if (next.gap > 0.0 && here.gap + next.gap < next.s - here.s && step > here.gap) {
                next = at(std::min(limit, here.s + std::max(here.gap, least_step_mm)));
            }
            if (next.gap <= 0.0) return root(here, next);
            here = next;
        }
        return std::nullopt;
    }

    /// From a touching place back to where the ball was last free.
    std::optional<Value> backward(Value here, double limit) const {
        for (int i = 0; i < most_steps; ++i) {
            if (here.s <= limit) return std::nullopt;
            Value next = at(std::max(limit, here.s - std::max(-here.gap, least_step_mm)));
            if (next.gap >= 0.0) return root(next, here);
            here = next;
        }
        return std::nullopt;
    }

    /// From a free place back to the nearest touching one, past which the ball was free again.
    std::optional<Value> touching_behind(Value here, double limit) const {
        for (int i = 0; i < most_steps; ++i) {
            if (here.s <= limit) return std::nullopt;
            here = at(std::max(limit, here.s - std::max(here.gap, least_step_mm)));
            if (here.gap < 0.0) return here;
        }
        return std::nullopt;
    }

  private:
    const Surface& surface_;
    const Eigen::Vector3d& start_;
    const Eigen::Vector3d& direction_;
    double radius_;
    std::size_t& warm_;
};

}  // namespace

std::optional<BallContact> touch_along(const Surface& surface, const Eigen::Vector3d& start_mm,
                                       const Eigen::Vector3d& direction_unit, double search_min_mm,
                                       double search_max_mm, double radius_mm, std::size_t& warm) {
    const GapLine line(surface, start_mm, direction_unit, radius_mm, warm);
    const auto first = line.at(std::clamp(0.0, search_min_mm, search_max_mm));
    std::optional<GapLine::Value> found;
    if (first.gap >= 0.0) {
        found = line.forward(first, search_max_mm);
        if (!found) {
            if (const auto behind = line.touching_behind(first, search_min_mm))
                found = line.backward(*behind, search_min_mm);
        }
    } else {
        found = line.backward(first, search_min_mm);
    }
    if (!found) return std::nullopt;
    return line.ball(*found);
}

}  // namespace cmm::sim
