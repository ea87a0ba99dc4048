// SPDX-License-Identifier: Apache-2.0
#include "acquisition/tolerance_watch.hpp"

#include <algorithm>
#include <cmath>

#include "acquisition/worst_place.hpp"
#include "fitting/statistics.hpp"

namespace cmm::acquisition {
namespace {

constexpr double looks_when_unknown = 1e4;
constexpr double risk_divided_by = 50.0;  // 5 % in the coverage of the largest: 0.1 % for all looks
constexpr double border_share = 0.25;     // of an edge, to either side of where it ends

double excess_mm(const Exceedance& place) {
    return std::abs(place.deviation_mm) - place.guard_mm - 0.5 * place.limit_mm;
}

}  // namespace

ToleranceWatch::ToleranceWatch(const SectionSetup& setup, std::size_t expected)
    : setup_(&setup),
      coverage_(fitting::coverage_95_of_largest(risk_divided_by *
                                                (expected > 0 ? static_cast<double>(expected) : looks_when_unknown))),
      shared_coverage_(fitting::coverage_95_of_largest(risk_divided_by * shared_values)) {}

/// What machine, probe and temperature may do at a place of the part.
double ToleranceWatch::machine_mm(const Eigen::Vector2d& position_mm, const Eigen::Vector2d& normal,
                                  double rise) const {
    if (!setup_->fields.any()) return 0.0;
    const auto loads = setup_->fields.at(position_mm, normal, rise);
    const double standard_mm = std::hypot(std::sqrt(fitting::variance_of(loads)), setup_->fields.place_mm(rise));
    return shared_coverage_ * standard_mm + std::abs(fitting::known_of(loads));
}

std::optional<double> ToleranceWatch::limit_of(fitting::Zone zone) const {
    if (setup_->alignment.kind != AlignmentKind::none) return std::nullopt;
    if (setup_->fitting.filters.at(zone).kind != fitting::FilterKind::none) return std::nullopt;
    const bool edge = zone == fitting::Zone::le || zone == fitting::Zone::te;
    return edge ? setup_->gate.edge_profile_mm : setup_->gate.profile_mm;
}

/// The widest of the zones to which the place may belong.
std::optional<double> ToleranceWatch::limit_at(double s_mm) const {
    const auto& nominal = setup_->nominal->section;
    const auto length = [](const fitting::ZoneSpan& span) { return span.to_mm - span.from_mm; };
    const double border_mm = border_share * std::max(length(nominal.le_span()), length(nominal.te_span()));
    std::optional<double> widest;
    for (const double beside_mm : {-border_mm, 0.0, border_mm}) {
        const auto limit = limit_of(nominal.zone_at(nominal.curve().wrap(s_mm + beside_mm)));
        if (!limit) return std::nullopt;
        widest = std::max(widest.value_or(0.0), *limit);
    }
    return widest;
}

/// None: nothing speaks for the place being out.
std::optional<Exceedance> ToleranceWatch::look(const fitting::LiveSpline::Point& place) {
    Exceedance found;
    found.position_mm = setup_->at_20_c(place.position) - setup_->ball_radius_mm * place.normal;
    found.sequence = place.sequence;
    const auto compared = setup_->nominal->reference.compare(found.position_mm, place.normal, near_mm_);
    near_mm_ = compared.s_mm;
    if (place.doubtful || place.skipped || !compared.deviation_mm) return std::nullopt;
    const auto limit = limit_at(compared.s_mm);
    if (!limit) return std::nullopt;
    found.zone = setup_->nominal->section.zone_at(compared.s_mm);
    found.limit_mm = *limit;
    found.deviation_mm = *compared.deviation_mm;
    found.guard_mm = coverage_ * place.sigma_mm + (found.deviation_mm > 0.0 ? compared.doubted_error_mm : 0.0) +
                     machine_mm(found.position_mm, place.normal, compared.rise);
    return excess_mm(found) > 0.0 ? std::optional(found) : std::nullopt;
}

/// Of the row: by their mean, whose noise is that of independent samples.
bool ToleranceWatch::samples_are_out(double noise_mm) const {
    double sum = 0.0;
    for (const double excess : excess_mm_)
        sum += excess;
    const auto count = static_cast<double>(in_a_row);
    return sum / count > coverage_ * noise_mm / std::sqrt(count);
}

void ToleranceWatch::see(const fitting::LiveSpline::Point& place, const Eigen::Vector2d& centre_mm, double noise_mm) {
    if (!setup_->nominal || !place.valid || place.sequence <= seen_) return;
    seen_ = place.sequence;
    const auto found = look(place);
    if (!found) {
        row_ = 0;
        return;
    }
    const bool outside = found->deviation_mm > 0.0;
    if (outside != outside_) row_ = 0;
    outside_ = outside;
    last_[row_ % in_a_row] = *found;
    // Seen along the place's normal, the sample lies as far from the nominal as the place and then beside the place.
    const double beside_mm = (centre_mm - place.position).dot(place.normal);
    const double off_mm = (outside ? 1.0 : -1.0) * (found->deviation_mm + beside_mm);
    const double no_noise_mm = found->guard_mm - coverage_ * place.sigma_mm;
    excess_mm_[row_ % in_a_row] = off_mm - no_noise_mm - 0.5 * found->limit_mm;
    if (++row_ < in_a_row || !samples_are_out(noise_mm)) return;
    // Of a row that has just become long enough all count, of a longer one the newest.
    for (const auto& one : last_)
        if (!worst_ || excess_mm(one) > excess_mm(*worst_)) worst_ = one;
}

}  // namespace cmm::acquisition
