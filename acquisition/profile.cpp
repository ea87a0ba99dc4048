// SPDX-License-Identifier: Apache-2.0
#include "acquisition/profile.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/worst_place.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using fitting::ContourPoint;

constexpr double shown_share = 0.0005;  // of a zone that is not evaluable: below 0.1 % nothing is said
constexpr const char* not_reached = "not evaluable there: the ball does not reach";
constexpr const char* only_a_gap = "it was not measured: a gap of the points";
constexpr const char* profile_method = "line profile ISO 1101, 2 max|d|, ";

std::optional<double> limit_of(const ProfileZone& zone, const EvaluationOptions& options) {
    return zone.edge ? options.edge_profile_mm : options.profile_mm;
}

std::string profile_method_of(const fitting::FilterSpec& filter, const std::string& frame) {
    static constexpr std::array<std::pair<fitting::FilterKind, const char*>, 3> names{
        {{fitting::FilterKind::gaussian, "Gaussian filter ISO 16610-21"},
         {fitting::FilterKind::spline, "spline filter ISO 16610-22"},
         {fitting::FilterKind::robust_gaussian, "robust Gaussian filter ISO 16610-31"}}};
    for (const auto& [kind, name] : names)
        if (kind == filter.kind)
            return profile_method + frame + ", " + name + ", cut-off " + core::fixed(filter.cutoff_mm, 3) + " mm";
    return profile_method + frame;
}

}  // namespace

std::string worst_note(double deviation_mm, const Vector2d& at) {
    return "worst d " + std::string(deviation_mm > 0 ? "+" : "") + core::length_text(deviation_mm) + " at x " +
           core::fixed(at.x(), 3) + " mm, y " + core::fixed(at.y(), 3) + " mm";
}

Characteristic profile(const ProfileZone& zone, const SectionResult& section, const Compared& compared,
                       const EvaluationOptions& options) {
    const auto& contour = compared.contour;
    const auto& deviation = compared.deviation;
    const auto limit = limit_of(zone, options);
    const std::string method = profile_method_of(options.filters.at(zone.zone), compared.frame);
    std::optional<std::size_t> worst;
    std::size_t points = 0;
    std::size_t judged = 0, unmeasured = 0;
    const auto in_zone = std::count_if(contour.begin(), contour.end(),
                                       [&](const ContourPoint& point) { return point.zone == zone.zone; });
    WorstPlace places(options.rule, section, static_cast<std::size_t>(in_zone));
    for (std::size_t i = 0; i < contour.size(); ++i) {
        if (contour[i].zone != zone.zone) continue;
        ++points;
        unmeasured += contour[i].measured ? 0 : 1;
        if (!deviation.values[i]) continue;
        ++judged;
        places.add(contour[i], scatter_u95_mm(contour[i], compared.alignment), std::abs(*deviation.values[i]));
        if (!worst || std::abs(*deviation.values[i]) > std::abs(*deviation.values[*worst])) worst = i;
    }
    if (points == 0) return not_evaluable(zone.name, method, limit, "the contour has no such zone");
    if (const auto& why = deviation.refused[static_cast<std::size_t>(zone.zone)]; !why.empty())
        return not_evaluable(zone.name, method, limit, why);
    const auto share_of = [&](std::size_t count) { return static_cast<double>(count) / static_cast<double>(points); };
    if (!worst) return not_evaluable(zone.name, method, limit, unmeasured == points ? only_a_gap : not_reached);
    const double largest = *deviation.values[*worst];
    const double scatter_mm = scatter_u95_mm(contour[*worst], compared.alignment);
    const double u95_mm = u95_of_worst(contour[*worst], scatter_mm, section);
    Characteristic c{zone.name, method, 2.0 * std::abs(largest), 2.0 * u95_mm, limit, Decision::reported, {}};
    c.note = worst_note(largest, contour[*worst].position_mm);
    if (const auto note = offset_error_note(contour[*worst].offset_error_mm, Unit::mm); !note.empty())
        c.note += "; " + note;
    if (const auto share = share_of(points - judged - unmeasured); share > shown_share)
        c.note += "; " + core::fixed(100.0 * share, 1) + " % of it " + not_reached;
    const auto& noise = section.fit->contour_noise;
    if (noise.has_fields()) c.budget = budget_at(contour[*worst], scatter_mm, noise.coverage()).times(2.0);
    const auto [accept, reject] = places.guards();  // of half the width
    c.guard_accept = 2.0 * accept;
    c.guard_reject = 2.0 * reject;
    know_gap(share_of(unmeasured), c);
    decide(c, options.rule);
    return c;
}

Characteristic profile_not_evaluable(const ProfileZone& zone, const EvaluationOptions& options,
                                     const std::string& why) {
    const auto method = profile_method_of(options.filters.at(zone.zone), frame_words(options.alignment));
    return not_evaluable(zone.name, method, limit_of(zone, options), why);
}

}  // namespace cmm::acquisition
