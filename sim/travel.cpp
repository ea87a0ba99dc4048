// SPDX-License-Identifier: Apache-2.0
#include "sim/travel.hpp"

#include <algorithm>

namespace cmm::sim {
namespace {

constexpr double touching_mm = 1e-6;   // closer than this is contact
constexpr double least_way_mm = 0.01;  // where the line runs almost along the surface
constexpr double near_mm = 2e-3;  // a ball this near has not left the part yet; going this much deeper is a collision

/// The straight way of a ball, as the gap between ball and part.
class Way {
  public:
    Way(const Surface& surface, const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius_mm)
        : surface_(surface), from_(from), radius_(radius_mm), length_((to - from).norm()) {
        if (length_ > 0.0) direction_ = (to - from) / length_;
    }
    double length() const { return length_; }
    double gap(double way) { return surface_.nearest(from_ + way * direction_, warm_).distance_mm - radius_; }

    /// Where the gap closes. The distance to a surface grows at most as fast as the way, so the ball may always go
    /// forward by the gap.
    std::optional<double> touch_after(double clear, double gap_there) {
        for (double here = clear;;) {
            if (here >= length_) return std::nullopt;
            here = std::min(length_, here + std::max(gap_there, least_way_mm));
            gap_there = gap(here);
            if (gap_there <= touching_mm) return closing_between(clear, here);
            clear = here;
        }
    }

  private:
    double closing_between(double open, double closed) {
        while (closed - open > touching_mm) {
            const double middle = (open + closed) / 2.0;
            (gap(middle) > 0.0 ? open : closed) = middle;
        }
        return closed;
    }

    const Surface& surface_;
    Eigen::Vector3d from_;
    Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();
    double radius_;
    double length_;
    std::size_t warm_ = 0;
};

}  // namespace

std::optional<double> first_contact(const Surface& surface, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                    double radius_mm) {
    Way way(surface, from, to, radius_mm);
    double gap = way.gap(0.0);
    const double deepest = std::min(gap, 0.0) - near_mm;
    double here = 0.0;
    while (gap <= near_mm) {  // starts in contact: let it leave or slide, but not go deeper
        if (here >= way.length()) return std::nullopt;
        const double next = std::min(way.length(), here + least_way_mm);
        gap = way.gap(next);
        if (gap < deepest) return here;
        here = next;
    }
    return way.touch_after(here, gap);
}

}  // namespace cmm::sim
