// SPDX-License-Identifier: Apache-2.0
#include "acquisition/points_out.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "acquisition/asked_characteristics.hpp"
#include "acquisition/worst_place.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

/// A point against the half width of its zone, by what it would have to err to be on the other side.
struct MeasuredPlace {
    double beyond_mm = 0.0;                                    ///< negative: inside
    double scatter_mm = 0.0, shared_mm = 0.0, bound_mm = 0.0;  // standard: of the points, and what the machine shares
};

class PointCount {
  public:
    PointCount(const CharacteristicSpec& spec, const SectionResult& section, const EvaluationOptions& options)
        : spec_(spec), section_(section), options_(options) {
        for (const auto& point : section.points) {
            if (point.verdict.reason == fitting::RejectReason::none)
                add(point);
            else
                ++left_out_;
        }
    }
    bool without_zone() const { return without_zone_; }
    bool empty() const { return places_.empty(); }

    void fill(Characteristic& c) const {
        const auto count = static_cast<double>(places_.size());
        const LargestGuard guard_of(options_.rule.risk_of_look(), count, std::min(count, shared_values));
        std::size_t out = 0, certain = 0, possible = 0;
        for (const auto& place : places_) {
            const double guard = guard_of(place.scatter_mm, place.shared_mm) + place.bound_mm;
            out += place.beyond_mm > 0.0 ? 1 : 0;
            certain += place.beyond_mm > guard ? 1 : 0;
            possible += place.beyond_mm > -guard ? 1 : 0;
        }
        const auto value = static_cast<double>(out);
        c.value = value;
        c.guard_accept = static_cast<double>(possible) - value;
        c.guard_reject = value - static_cast<double>(certain);
        c.u95 = std::max(*c.guard_accept, *c.guard_reject);
        c.note = std::to_string(out) + " of " + std::to_string(places_.size()) + " points (" +
                 core::fixed(100.0 * value / static_cast<double>(places_.size()), 1) + " %), " +
                 std::to_string(certain) + " for certain, " + std::to_string(possible) + " at most";
        if (left_out_ > 0) c.note += "; " + std::to_string(left_out_) + " left out of the whole section do not count";
        if (not_reached_ > 0) c.note += "; " + std::to_string(not_reached_) + " where the ball does not reach";
    }

  private:
    std::size_t foot_of(const Eigen::Vector2d& centre_mm) const {
        const auto& contour = section_.fit->contour;
        const auto squared = [&](const fitting::ContourPoint& p) {
            return p.measured ? (p.position_mm - centre_mm).squaredNorm() : std::numeric_limits<double>::infinity();
        };
        const auto nearest = std::min_element(contour.begin(), contour.end(),
                                              [&](const auto& a, const auto& b) { return squared(a) < squared(b); });
        return static_cast<std::size_t>(nearest - contour.begin());
    }

    void add(const RecordedPoint& point) {
        const std::size_t foot = foot_of(point.centre_mm.head<2>());
        const auto& place = section_.fit->contour[foot];
        if (spec_.zone && place.zone != *spec_.zone) return;
        const bool edge = place.zone == fitting::Zone::le || place.zone == fitting::Zone::te;
        const auto width = spec_.width_mm ? spec_.width_mm : edge ? options_.edge_profile_mm : options_.profile_mm;
        if (!width) {
            without_zone_ = true;
            return;
        }
        if (!section_.deviation_mm[foot]) {
            ++not_reached_;
            return;
        }
        const double bound = place.offset_error_mm + place.bound_mm;
        const double of_contour =
            std::max(0.0, scatter_u95_mm(place, section_.alignment) - bound) / section_.fit->contour_noise.coverage();
        const double deviation = *section_.deviation_mm[foot] + point.verdict.residual_mm;
        places_.push_back({std::abs(deviation) - 0.5 * *width, std::hypot(section_.fit->noise_sigma_mm, of_contour),
                           place.machine.shared_mm(), bound + std::abs(place.machine.known_mm)});
    }

    const CharacteristicSpec& spec_;
    const SectionResult& section_;
    const EvaluationOptions& options_;
    std::vector<MeasuredPlace> places_;
    std::size_t left_out_ = 0, not_reached_ = 0;
    bool without_zone_ = false;
};

}  // namespace

Characteristic points_out(const CharacteristicSpec& spec, const SectionResult& section,
                          const EvaluationOptions& options) {
    Characteristic c;
    c.name = spec.label;
    c.method = "POINTSOUT: measured points outside the tolerance zone, " + frame_words(options.alignment);
    c.unit = unit_of(spec.kind);
    c.nominal = 0.0;
    c.decision = Decision::not_evaluable;
    set_limits(spec, c);
    if (section.deviation_mm.empty()) {
        c.note = section.alignment.note.empty() ? "there is no nominal" : section.alignment.note;
        return c;
    }
    const PointCount count(spec, section, options);
    if (count.without_zone()) {
        c.note = "no tolerance zone is known there: [gate], or width_mm";
    } else if (count.empty()) {
        c.note = "no point there";
    } else {
        c.decision = Decision::reported;
        count.fill(c);
        decide(c, options.rule);
    }
    return c;
}

}  // namespace cmm::acquisition
