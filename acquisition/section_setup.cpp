// SPDX-License-Identifier: Apache-2.0
#include "acquisition/section_setup.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "acquisition/evaluation.hpp"
#include "acquisition/live_section.hpp"
#include "acquisition/part_frame.hpp"
#include "core/text.hpp"
#include "fitting/stray_points.hpp"

namespace cmm::acquisition {

core::Result<SectionSetup> make_section_setup(const PartFile& part, const Nominal* nominal, std::size_t index,
                                              double z_mm) {
    SectionSetup setup;
    setup.index = index;
    setup.name = std::to_string(index);
    setup.z_mm = z_mm;
    setup.ball_radius_mm = part.stylus.radius_mm;
    setup.le_hint_mm = part.nominal.le_hint_mm;
    setup.fitting = part.fitting;
    setup.alignment = part.alignment;
    setup.gate = part.gate;
    setup.fields = fitting::ErrorFields(part.uncertainty.errors(), z_mm);
    double height_mm = z_mm;
    if (part.uncertainty.correction == ExpansionCorrection::applied) {
        const auto& fixed_at_mm = part.uncertainty.fixed_at_mm;
        setup.to_20_c = 1.0 / (1.0 + part.uncertainty.growth());
        setup.fixed_at_mm = fixed_at_mm.head<2>();
        setup.ball_radius_mm *= setup.to_20_c;
        height_mm = fixed_at_mm.z() + setup.to_20_c * (z_mm - fixed_at_mm.z());
    }
    if (nominal == nullptr) return setup;

    auto contour = nominal->cut(height_mm);
    if (!contour) return tl::unexpected(contour.error());
    auto analysed = fitting::analyse_nominal(contour->points, edge_hints(part.nominal, *contour));
    if (!analysed) {
        return core::fail(core::ErrorCode::input_invalid,
                          "the nominal at z " + core::fixed(z_mm, 3) + " mm: " + analysed.error().text());
    }
    if (!setup.gate.characteristics.empty())
        setup.nominal_measures = std::make_shared<const NominalMeasures>(*analysed, index, setup.gate.characteristics);
    ReferenceContour reference(*contour, analysed->curve(), part.stylus.radius_mm);
    setup.nominal = SectionNominal{std::move(*analysed), std::move(reference), contour->surface, contour->lean_rad};
    return setup;
}

fitting::SectionOptions section_options(const SectionSetup& setup) {
    fitting::SectionOptions options;
    options.ball_radius_mm = setup.ball_radius_mm;
    options.le_hint = setup.le_hint_mm;
    options.le_model = setup.fitting.le_model;
    options.te_model = setup.fitting.te_model;
    options.fairing_mm = setup.fitting.fairing_mm;
    if (setup.nominal) {
        options.le_hint = setup.nominal->section.le_point();
        options.te_hint = setup.nominal->section.te_point();
        options.nominal = &setup.nominal->section.curve();
    }
    return options;
}

namespace {

/// A section that was called out while it was measured, and not measured to its end, stays rejected however it is
/// judged.
void keep_called_out(const SectionSetup& setup, SectionResult& section) {
    if (section.all_round() || !setup.nominal || section.decision() == Decision::reject) return;
    LiveSection live(setup, 1.0, core::PartFromMachine(), section.points.size());
    live.restore(section.points);
    if (live.exceedance()) reject_by(*live.exceedance(), section);
}

/// A setup as evaluation.hpp wants it.
struct Evaluation {
    EvaluationOptions options;
    const ReferenceContour* nominal = nullptr;
    const fitting::NominalSection* curve = nullptr;
    const SectionAlignment* shared;
    SectionAlignment unknown;

    Evaluation(const SectionSetup& setup, const SectionAlignment* of_blade, Lean lean) : shared(of_blade) {
        options.profile_mm = setup.gate.profile_mm;
        options.edge_profile_mm = setup.gate.edge_profile_mm;
        options.filters = setup.fitting.filters;
        options.asked = setup.gate.characteristics;
        options.le_model = setup.fitting.le_model;
        options.te_model = setup.fitting.te_model;
        options.rule = setup.gate.rule;
        options.alignment = setup.alignment;
        options.nominal_measures = setup.nominal_measures.get();
        options.lean = lean;
        options.plane = setup.plane;
        if (setup.nominal) {
            nominal = &setup.nominal->reference;
            curve = &setup.nominal->section;
        }
        if (setup.alignment.kind != AlignmentKind::six_points) return;
        if (!setup.frame) unknown = without_frame(setup.alignment);
        shared = setup.frame ? &*setup.frame : &unknown;
    }
    Evaluation(const Evaluation&) = delete;
    Evaluation& operator=(const Evaluation&) = delete;

    SectionResult lay(SectionResult section, core::Result<fitting::SectionFit> fit, const SectionSetup& setup) const {
        if (fit && setup.fields.any()) fit->contour_noise.set_fields(setup.fields);
        section = lay_section(std::move(section), std::move(fit), nominal, options, curve, shared);
        if (setup.nominal) section.nominal_surface = setup.nominal->surface;
        return section;
    }
    SectionResult judge(SectionResult section, const SectionSetup& setup) const {
        section = judge_section(std::move(section), nominal, options, curve, shared);
        keep_called_out(setup, section);
        return section;
    }
};

}  // namespace

SectionResult judge_fit(SectionResult section, core::Result<fitting::SectionFit> fit, const SectionSetup& setup,
                        const SectionAlignment* shared, Lean lean) {
    const Evaluation evaluation(setup, shared, lean);
    return evaluation.judge(evaluation.lay(std::move(section), std::move(fit), setup), setup);
}

SectionResult judge_laid(SectionResult section, const SectionSetup& setup) {
    return Evaluation(setup, nullptr, Lean::nominal).judge(std::move(section), setup);
}

namespace {

using fitting::RejectReason;

constexpr double most_off_plane_mm = 0.5;
constexpr std::size_t one_of_so_many = 10;  // may lie farther off the plane

/// A section lies in one plane z = const; a profile on a stream surface does not.
core::Status require_plane(std::vector<double> z_mm) {
    if (z_mm.empty()) return {};
    const auto [low, high] = std::minmax_element(z_mm.begin(), z_mm.end());
    const double lowest = *low, highest = *high;
    if (highest - lowest <= most_off_plane_mm) return {};
    const auto middle = z_mm.begin() + static_cast<std::ptrdiff_t>(z_mm.size() / 2);
    std::nth_element(z_mm.begin(), middle, z_mm.end());
    const double plane = *middle;
    const auto off =
        std::count_if(z_mm.begin(), z_mm.end(), [&](double z) { return std::abs(z - plane) > most_off_plane_mm; });
    if (static_cast<std::size_t>(off) * one_of_so_many <= z_mm.size()) return {};
    return core::fail(core::ErrorCode::fit_not_evaluable,
                      "section: its points lie between z " + core::fixed(lowest, 3) + " and " +
                          core::fixed(highest, 3) + " mm, not in one plane z = const");
}

/// The points of a section as fit_section takes them, with the verdicts that they bring along.
struct FitPoints {
    std::vector<Eigen::Vector2d> centres;
    std::vector<double> z_mm;  // of those that count
    std::vector<RejectReason> excluded;
    std::vector<char> kept, later;

    FitPoints(const SectionSetup& setup, std::span<const RecordedPoint> points) {
        centres.reserve(points.size());
        z_mm.reserve(points.size());
        excluded.reserve(points.size());
        kept.reserve(points.size());
        later.reserve(points.size());
        for (const auto& point : points) {
            centres.push_back(setup.at_20_c(point.centre_mm.head<2>()));
            const RejectReason reason = point.verdict.reason;
            const bool stands = reason == RejectReason::no_contact || reason == RejectReason::by_operator;
            excluded.push_back(stands ? reason : RejectReason::none);
            if (!stands) z_mm.push_back(point.centre_mm.z());
            kept.push_back(static_cast<char>(point.verdict.kept));
            later.push_back(static_cast<char>(std::min<int>(point.pass, std::numeric_limits<signed char>::max())));
        }
    }
    core::Result<fitting::SectionFit> fit(const fitting::SectionOptions& options) const {
        if (auto status = require_plane(z_mm); !status) return tl::unexpected(status.error());
        return fitting::fit_contour(centres, excluded, options, kept, later);
    }
};

}  // namespace

std::optional<fitting::SectionFit> fit_without_strays(const fitting::SurfaceCompensation& surface,
                                                      const SectionSetup& setup, const SectionResult& section,
                                                      const fitting::SectionFit& flat) {
    FitPoints points(setup, section.points);
    const auto strays = fitting::stray_points(surface, section.z_mm, points.centres, flat.verdicts);
    if (!strays.any()) return std::nullopt;
    // What the section has left out stays out, but for what comes back: bad points could pass beside one that did.
    for (std::size_t i = 0; i < flat.verdicts.size(); ++i)
        if (fitting::is_left_out(flat.verdicts[i])) points.excluded[i] = flat.verdicts[i].reason;
    for (const auto& stray : strays.bad)
        points.excluded[stray.index] = RejectReason::fit_residual;
    for (const auto& stray : strays.good) {
        points.excluded[stray.index] = RejectReason::none;
        points.kept[stray.index] = 1;
    }
    auto options = section_options(setup);
    options.le_hint = flat.le_point_mm;
    options.te_hint = flat.te_point_mm;
    auto fit = points.fit(options);
    if (!fit) return std::nullopt;
    fitting::fit_edges(*fit);
    for (std::size_t i = 0; i < flat.verdicts.size(); ++i)
        if (fitting::is_left_out(flat.verdicts[i]) && points.excluded[i] == flat.verdicts[i].reason)
            fit->verdicts[i].residual_mm = flat.verdicts[i].residual_mm;
    for (const auto& stray : strays.bad)
        fit->verdicts[stray.index].residual_mm = stray.off_mm;
    for (const auto& stray : strays.good)
        fit->verdicts[stray.index].kept = false;  // by the others, not by an operator
    return std::move(*fit);
}

SectionResult SectionJudge::close(const SectionSetup& setup, std::vector<RecordedPoint> points) {
    auto options = section_options(setup);
    if (!options.le_hint && last_le_mm_) {
        options.le_hint = last_le_mm_;
        options.te_hint = last_te_mm_;
    }
    auto fit = FitPoints(setup, points).fit(options);
    if (fit && fit->missing.empty()) {
        last_le_mm_ = fit->le_point_mm;
        last_te_mm_ = fit->te_point_mm;
    }
    SectionResult section;
    section.index = setup.index;
    section.name = setup.name;
    section.z_mm = setup.z_mm;
    section.points = std::move(points);
    return Evaluation(setup, nullptr, Lean::nominal).lay(std::move(section), std::move(fit), setup);
}

SectionResult SectionJudge::finish(const SectionSetup& setup, std::vector<RecordedPoint> points) {
    return judge_laid(close(setup, std::move(points)), setup);
}

}  // namespace cmm::acquisition
