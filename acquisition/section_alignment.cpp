// SPDX-License-Identifier: Apache-2.0
#include "acquisition/section_alignment.hpp"

#include <memory>
#include <utility>

#include "fitting/measured_section.hpp"

namespace cmm::acquisition {
namespace {

Alignment described_alignment(const AlignmentSpec& spec, const fitting::BestFit& fit, const fitting::Datum& datum,
                              std::size_t sections) {
    Alignment out;
    out.state = Alignment::State::final;
    out.spec = spec;
    out.motion = fit.motion;
    out.covariance = datum.covariance;
    out.loads = datum.loads;
    out.rms_mm = fit.rms_mm;
    out.largest_mm = fit.largest_mm;
    out.condition = fit.condition;
    out.rounds = fit.rounds;
    out.sections = sections;
    return out;
}

}  // namespace

fitting::BestFitOptions best_fit_options(const AlignmentSpec& spec, const ProfileWidths& widths) {
    fitting::BestFitOptions options;
    options.objective = spec.objective;
    options.translate_x = spec.translate_x;
    options.translate_y = spec.translate_y;
    options.rotate = spec.rotate;
    options.zones = spec.zones;
    if (spec.objective != fitting::FitObjective::into_tolerance) return options;
    for (const auto zone : {fitting::Zone::le, fitting::Zone::suction, fitting::Zone::te, fitting::Zone::pressure}) {
        const auto k = static_cast<std::size_t>(zone);
        const bool edge = zone == fitting::Zone::le || zone == fitting::Zone::te;
        const auto& width = edge ? widths.edge_mm : widths.side_mm;
        if (width)
            options.tolerance[k].half_mm = 0.5 * *width;
        else
            options.zones[k] = false;
    }
    return options;
}

std::vector<char> reached(std::span<const std::optional<double>> deviation_mm) {
    std::vector<char> use;
    use.reserve(deviation_mm.size());
    for (const auto& deviation : deviation_mm)
        use.push_back(static_cast<char>(deviation.has_value()));
    return use;
}

core::Result<std::vector<SectionAlignment>> align_blade(std::span<const AlignedMember> members,
                                                        const AlignmentSpec& spec, const ProfileWidths& widths) {
    std::vector<std::unique_ptr<fitting::MeasuredSection>> sections;
    std::vector<const fitting::MeasuredSection*> measured;
    std::vector<fitting::FitMember> to_fit;
    for (const AlignedMember& member : members) {
        sections.push_back(std::make_unique<fitting::MeasuredSection>(*member.fit));
        measured.push_back(sections.back().get());
        to_fit.push_back({&sections.back()->contour(), member.nominal, member.use});
    }
    const auto fit = fitting::fit_to_nominals(to_fit, best_fit_options(spec, widths));
    if (!fit) return tl::unexpected(fit.error());
    std::vector<SectionAlignment> out;
    for (auto& datum : fitting::datums_of(*fit, measured)) {
        Alignment alignment = described_alignment(spec, *fit, datum, members.size());
        out.push_back({std::move(alignment), std::move(datum)});
    }
    return out;
}

core::Result<SectionAlignment> align_section(const fitting::SectionFit& fit, const ReferenceContour& reference,
                                             const fitting::ClosedCurve& nominal, const AlignmentSpec& spec,
                                             const ProfileWidths& widths) {
    auto compared = fit.contour;
    const AlignedMember member{&fit, &nominal, reached(reference.compare(compared))};
    auto aligned = align_blade({&member, 1}, spec, widths);
    if (!aligned) return tl::unexpected(aligned.error());
    return std::move(aligned->front());
}

std::vector<std::optional<double>> compare_aligned(std::vector<fitting::ContourPoint>& contour,
                                                   const ReferenceContour& reference,
                                                   const fitting::PlaneMotion& motion, Lean lean) {
    auto moved = contour;
    for (auto& point : moved) {
        point.position_mm = motion.undo(point.position_mm);
        point.normal = motion.undo_on_direction(point.normal);
    }
    auto deviations = reference.compare(moved, lean);
    for (std::size_t i = 0; i < contour.size(); ++i) {
        contour[i].u95_mm = moved[i].u95_mm;
        contour[i].offset_error_mm = moved[i].offset_error_mm;
        contour[i].rise = moved[i].rise;
    }
    return deviations;
}

}  // namespace cmm::acquisition
