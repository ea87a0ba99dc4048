// SPDX-License-Identifier: Apache-2.0
#include "fitting/nominal.hpp"

#include <algorithm>
#include <utility>

#include "fitting/edges.hpp"

namespace cmm::fitting {

bool NominalSection::inside(const ZoneSpan& span, double s_mm) const {
    return curve_.ahead(span.from_mm, s_mm) <= span.to_mm - span.from_mm;
}

Zone NominalSection::zone_at(double s_mm) const {
    if (inside(le_, s_mm)) return Zone::le;
    if (inside(te_, s_mm)) return Zone::te;
    return side_at(s_mm);
}

Zone NominalSection::side_at(double s_mm) const {
    const bool after_le = curve_.ahead(le_mm_, s_mm) < curve_.ahead(le_mm_, te_mm_);
    return after_le == suction_after_le_ ? Zone::suction : Zone::pressure;
}

ZoneSpan NominalSection::span_of(Zone zone) const {
    if (zone == Zone::le) return le_;
    if (zone == Zone::te) return te_;
    const bool after_le = (zone == Zone::suction) == suction_after_le_;
    const ZoneSpan &before = after_le ? le_ : te_, &behind = after_le ? te_ : le_;
    return {before.to_mm, before.to_mm + curve_.ahead(before.to_mm, behind.from_mm)};
}

core::Result<NominalSection> analyse_nominal(std::span<const Vec2> points, const NominalOptions& options) {
    auto curve = ClosedCurve::through(points);
    if (!curve) return tl::unexpected(curve.error());
    NominalSection nominal;
    nominal.curve_ = std::move(*curve);
    nominal.curve_.note_clearances();  // contours lie near it
    const auto samples =
        offset_curve(nominal.curve_.spline(), 0.0, std::max<std::size_t>(2000, 4 * points.size())).points;
    const auto edges = find_edges(samples, options.le_hint, options.te_hint);
    if (!edges) return tl::unexpected(edges.error());
    const auto place = [&](std::size_t i) { return nominal.curve_.arc_length_at(samples[i].t); };
    const auto stretch = [&](const EdgeRegion& region) {
        const double from = place(region.begin);
        return ZoneSpan{from, from + nominal.curve_.ahead(from, place(region.end))};
    };
    nominal.le_ = stretch(edges->le);
    nominal.te_ = stretch(edges->te);
    const auto nose = [&](const EdgeRegion& region) {
        const double from = place((region.nose + samples.size() - 1) % samples.size()), to = place(region.nose);
        return nominal.curve_.wrap(to - region.nose_share * nominal.curve_.ahead(from, to));
    };
    nominal.le_mm_ = nose(edges->le);
    nominal.te_mm_ = nose(edges->te);
    nominal.le_radius_ = edges->le.scale_mm;
    nominal.te_radius_ = edges->te.scale_mm;
    nominal.suction_after_le_ = edges->suction_after_le;
    return nominal;
}

}  // namespace cmm::fitting
