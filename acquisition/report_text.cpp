// SPDX-License-Identifier: Apache-2.0
#include "acquisition/report_text.hpp"

#include <algorithm>
#include <array>

#include "acquisition/alignment.hpp"
#include "acquisition/part_frame.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

constexpr std::array always_reported{
    ReportTerm{"profile_le", "Profile LE"}, ReportTerm{"profile_suction", "Profile suction"},
    ReportTerm{"profile_te", "Profile TE"}, ReportTerm{"profile_pressure", "Profile pressure"},
    ReportTerm{"le_radius", "LE radius"},   ReportTerm{"te_radius", "TE radius"},
    ReportTerm{"chord", "Chord"},           ReportTerm{"max_thickness", "Max. thickness"}};
constexpr int radius_digits = 4;

/// A line of the terminal for a reader: real signs, words without underscores, no break inside an inequality.
std::string typeset(std::string reason) {
    const auto replace_all = [&reason](std::string_view from, std::string_view to) {
        for (auto at = reason.find(from); at != std::string::npos; at = reason.find(from, at + to.size())) {
            reason.replace(at, from.size(), to);
        }
    };
    replace_all("+-", "\u00b1");
    replace_all(" mm", "\u00a0mm");
    replace_all(" > ", "\u00a0>\u00a0");
    replace_all("_", " ");
    return reason;
}

std::string compensation_text(const Compensation& compensation) {
    switch (compensation.state) {
        case Compensation::State::final: {
            std::string text = ", " + std::string(fitting::words_for(compensation.asked)) +
                               " moved the contour by up to " + core::fixed(compensation.from_flat_mm * 1e3, 1) +
                               " \u00b5m";
            constexpr double whole = 0.9995;
            if (compensation.share < whole) text += " (" + core::fixed(100.0 * compensation.share, 1) + " % of it)";
            if (compensation.set_aside > 0)
                text += " (" + std::to_string(compensation.set_aside) + " contacts out of order set aside)";
            if (!compensation.note.empty()) text += ", " + compensation.note;
            return text;
        }
        case Compensation::State::provisional:
            return ", provisional";
        case Compensation::State::flat:
            return compensation.note.empty() ? "" : ", 2-D compensation: " + compensation.note;
    }
    return {};
}

/// A part that was compensated point by point: how, before what is usual.
std::string point_by_point_text(const PartResult& part) {
    const auto section = std::find_if(part.sections.begin(), part.sections.end(), [](const auto& s) {
        return fitting::is_point_by_point(s.compensation.asked) && s.compensation.state != Compensation::State::flat;
    });
    if (section == part.sections.end()) return {};
    std::string how(fitting::words_for(section->compensation.asked));
    how.front() = 'C';
    return how +
           " was asked for: each contact lies one ball radius from its centre, along a normal of its own that is found "
           "from the neighbouring centres, or for point distance from the nominal, and the contour goes through the "
           "contacts in the plane of the section; U95 is that of their scatter and holds no error of the method "
           "(docs/compensation.md). ";
}

std::string again_text(const SectionResult& section) {
    const auto passes = points_of_passes(section);
    if (passes.empty()) return {};
    std::size_t points = 0;
    for (const auto& [pass, count] : passes)
        points += count;
    return ", " + std::to_string(points) + " of them measured again because the section was undecided (" +
           std::to_string(passes.size()) + (passes.size() == 1 ? " pass)" : " passes)");
}

std::string machine_text(const PartResult& part) {
    if (!part.uncertainty.errors().any()) return "The machine\u2019s own length error is not included.";
    return "Machine, probe and temperature are included as stated above, as errors that all points share: a largest "
           "permissible error counts as one that is equally likely anywhere within it (ISO 14253-2), and what an "
           "alignment takes away does not count.";
}

std::string reference_of(const PartResult& part) {
    if (!part.has_nominal) return "none: measured without a nominal";
    const Alignment* alignment = part.alignment();
    return "nominal contour, " + frame_words(alignment != nullptr ? alignment->spec : AlignmentSpec{});
}

/// Of the blade; that of single sections stands with each of them.
std::string alignment_of(const PartResult& part) {
    const Alignment* alignment = part.alignment();
    return alignment != nullptr && alignment->spec.kind == AlignmentKind::blade ? alignment_words(*alignment)
                                                                                : std::string();
}

}  // namespace

const Characteristic* first_of(const PartResult& part, std::string_view name) {
    for (const auto& section : part.sections) {
        if (const auto* c = section.find(name); c != nullptr) return c;
    }
    return nullptr;
}

std::vector<ReportTerm> report_terms(const PartResult& part) {
    std::vector<ReportTerm> terms;
    for (const auto& term : always_reported)
        if (first_of(part, term.name) != nullptr) terms.push_back(term);
    return terms;
}

std::vector<std::pair<std::string, std::string>> report_facts(const PartResult& part) {
    std::size_t points = 0;
    std::size_t rejected = 0;
    for (const auto& section : part.sections) {
        points += section.points.size();
        rejected += section.rejected();
    }
    std::vector<std::pair<std::string, std::string>> facts{
        {"Serial number", part.part_serial},
        {"Machine", part.machine},
        {"Started", part.started_utc},
        {"Run", part.run_id},
        {"Stylus ball radius", core::fixed(part.ball_radius_mm, radius_digits) + " mm"},
        {"Reference", reference_of(part)},
        {"Part frame", part.part_frame ? part_frame_words(*part.part_frame) : std::string()},
        {"Alignment", alignment_of(part)},
        {"Uncertainty holds", uncertainty_words(part.uncertainty)},
        {"Points", std::to_string(points) + " recorded, " + std::to_string(rejected) + " rejected"},
        {"Software", part.software_version}};
    std::erase_if(facts, [](const auto& fact) { return fact.second.empty(); });
    return facts;
}

std::string verdict_detail(const PartResult& part) {
    const auto total = std::to_string(part.sections.size());
    const auto count = [&](Decision decision) {
        return std::to_string(std::count_if(part.sections.begin(), part.sections.end(),
                                            [&](const auto& section) { return section.decision() == decision; }));
    };
    switch (part.verdict()) {
        case Decision::reject:
            return count(Decision::reject) + " of " + total + " sections outside tolerance";
        case Decision::accept:
            return part.has_requirements() ? "all " + total + " sections within tolerance"
                                           : total + " sections measured, nothing to judge";
        default:
            return part.complete ? count(Decision::undecided) + " of " + total + " sections undecided"
                                 : std::string("the measurement ended early");
    }
}

std::vector<std::string> typeset_reasons(const PartResult& part) {
    auto reasons = verdict_reasons(part);
    for (auto& reason : reasons)
        reason = typeset(std::move(reason));
    return reasons;
}

std::string title_of(const SectionResult& section) {
    return "Section " + std::to_string(section.index) + ", z = " + core::fixed(section.z_mm, 3) + " mm";
}

std::string summary_of(const SectionResult& section) {
    std::string text = std::to_string(section.points.size()) + " points" + again_text(section) + ", " +
                       std::to_string(section.rejected()) + " rejected";
    if (!section.has_contour()) return text;
    text += ", scatter " + core::fixed(section.fit->noise_sigma_mm * 1e3, 1) + " \u00b5m (1 \u03c3)";
    text += compensation_text(section.compensation);
    if (section.alignment.spec.kind == AlignmentKind::section || section.alignment.state == Alignment::State::refused)
        text += ", alignment " + alignment_words(section.alignment);
    if (const std::size_t gaps = section.gaps().size(); gaps > 0)
        text += ", " + std::to_string(gaps) + (gaps == 1 ? " gap" : " gaps") + " of " +
                core::length_text(section.missing_mm()) + " in which nothing was measured";
    if (const auto count = section.not_reached(); count > 0)
        text += ", the ball does not reach " + std::to_string(count) + " of " +
                std::to_string(section.fit->contour.size()) + " contour points";
    return text;
}

std::string not_all_round_text(const SectionResult& section) {
    return (section.has_contour() ? "Measured in part: " : "Not evaluable: ") + section.why_not_all_round();
}

std::string words(Decision decision) {
    std::string text(to_string(decision));
    std::replace(text.begin(), text.end(), '_', ' ');
    return text;
}

std::string capital(std::string text) {
    if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
    return text;
}

std::vector<std::pair<std::string, std::string>> report_methods(const PartResult& part) {
    std::vector<std::pair<std::string, std::string>> methods;
    for (const auto& term : report_terms(part))
        methods.emplace_back(term.title, first_of(part, term.name)->method);
    methods.emplace_back("Decision", part.decision_rule + ". A lower limit the other way round.");
    methods.emplace_back(
        "Uncertainty",
        "U95 is expanded (k = 2) from the scatter of the points about the fit, less what the neighbouring "
        "sections average of it, with what is not known of the lean. Where the ball "
        "is compensated in 2-D, the error of that, r (1/cos lean \u2212 1) by the nominal\u2019s lean at "
        "each point, is added. " +
            machine_text(part));
    methods.emplace_back(
        "Compensation",
        point_by_point_text(part) +
            "3-D: the contour is that of the surface of contacts in the plane of the section; contacts lie "
            "one ball radius inside the surface through the ball centres of all sections, along its normal. "
            "2-D: the ball radius is taken off in the plane of the section, along the normal of the fitted "
            "curve of ball centres.");
    methods.emplace_back(
        "Alignment",
        "Nominal frame: the machine\u2019s part frame is that of the nominal. Six datum points (RPS): touched before "
        "the "
        "first section, in rounds, until each touch is where it is expected; the sections are measured in the frame "
        "that "
        "they fix, and the U95 of deviations holds what the touches leave open. Best fit: the nominal laid onto the "
        "measured contour by closest points, each with the length of contour that it stands for; of the section by "
        "itself (form without location) or of all sections as one rigid body. Deviations are taken after it, and their "
        "U95 holds its standard uncertainty.");
    methods.emplace_back(
        "Reach",
        "Hollows of the nominal that are sharper than the ball are not compared: the ball rests on both "
        "ends and the contour shows the ball there.");
    methods.emplace_back(
        "Rejected points",
        "Points that lie off the curve through their neighbours, by more than the larger of the stated "
        "floor and the robust scatter, are marked and not used. Nothing is deleted.");
    return methods;
}

}  // namespace cmm::acquisition
