// SPDX-License-Identifier: Apache-2.0
#include "acquisition/span_point.hpp"

#include <cmath>

#include "fitting/datum.hpp"
#include "fitting/measured_section.hpp"

namespace cmm::acquisition {
namespace {

constexpr double farthest_mm = 5.0;  // a contour that passes beyond is not this side

double place_on_side(const fitting::NominalSection& nominal, fitting::Zone side, double share) {
    const auto& curve = nominal.curve();
    const double from_mm = curve.wrap(nominal.le_span().to_mm), to_mm = curve.wrap(nominal.te_span().from_mm);
    const double after_le_mm = curve.ahead(from_mm, to_mm);
    if (nominal.zone_at(curve.wrap(from_mm + 0.5 * after_le_mm)) == side)
        return curve.wrap(from_mm + share * after_le_mm);
    const double back_from_mm = curve.wrap(nominal.le_span().from_mm);
    return curve.wrap(back_from_mm - share * curve.ahead(curve.wrap(nominal.te_span().to_mm), back_from_mm));
}

}  // namespace

std::optional<SpanPoint> span_point(const fitting::SectionFit& fit, const fitting::NominalSection& nominal,
                                    const Alignment& alignment, const CharacteristicSpec& spec) {
    const auto on_nominal = nominal.curve().evaluate(place_on_side(nominal, spec.side, spec.share));
    const auto& motion = alignment.motion;
    const fitting::Vec2 foot = motion.apply(on_nominal.position);
    const fitting::Vec2 normal = motion.apply_to_direction(on_nominal.normal);
    const fitting::MeasuredSection measured(fit);
    const auto place = measured.contour().crossing(foot, normal, measured.contour().whole());
    if (place.index >= measured.contour().size()) return std::nullopt;
    SpanPoint out;
    out.label = spec.label;
    out.deviation_mm = (measured.contour().position(place) - foot).dot(normal);
    const double cosine = measured.contour().normal(place).dot(normal);
    if (std::abs(out.deviation_mm) > farthest_mm || cosine < 0.5) return std::nullopt;
    fitting::Measure measure{"", out.deviation_mm, {}, {}};
    measured.contour().add(place, 1.0 / cosine, measure.slopes);
    const auto uncertainty = measured.uncertainty(measure);
    if (uncertainty.in_gaps > 0.0) return std::nullopt;
    out.scatter_mm = uncertainty.scatter;
    out.place_mm = uncertainty.place;
    out.loads = uncertainty.loads - alignment.loads.transpose() * fitting::answer_to_motion(motion, foot, normal);
    return out;
}

}  // namespace cmm::acquisition
