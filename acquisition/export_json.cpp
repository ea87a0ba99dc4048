// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "acquisition/budget_table.hpp"
#include "acquisition/exports.hpp"
#include "acquisition/file_number.hpp"
#include "acquisition/traceability.hpp"

namespace cmm::acquisition {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
    return std::isfinite(value) ? Json(file_number(value)) : Json(nullptr);
}
Json number(const std::optional<double>& value) {
    return value ? number(*value) : Json(nullptr);
}

Json budget(const fitting::ErrorBudget& budget) {
    Json out = Json::object();
    const auto parts = parts_of(budget);
    for (std::size_t k = 0; k < parts.size(); ++k)
        out[budget_words.at(k).key] = number(parts.at(k));
    return out;
}

Json characteristic(const Characteristic& c) {
    Json out{{"name", c.name},
             {"value_mm", number(in_mm(c, c.value))},
             {"u95_mm", number(in_mm(c, c.u95))},
             {"limit_mm", number(in_mm(c, c.upper))},
             {"unit", to_string(c.unit)},
             {"value", number(c.value)},
             {"u95", number(c.u95)},
             {"nominal", number(c.nominal)},
             {"lower", number(c.lower)},
             {"upper", number(c.upper)},
             {"guard_accept", number(c.guard_accept)},
             {"guard_reject", number(c.guard_reject)},
             {"decision", to_string(c.decision)},
             {"method", c.method},
             {"note", c.note}};
    if (c.budget) out["budget"] = budget(*c.budget);
    return out;
}

Json place_of(const RecordedPoint& point) {
    return {{"seq", point.sequence},
            {"x_mm", number(point.centre_mm.x())},
            {"y_mm", number(point.centre_mm.y())},
            {"z_mm", number(point.centre_mm.z())},
            {"residual_mm", number(point.verdict.residual_mm)}};
}

Json rejected_points(const SectionResult& section) {
    Json points = Json::array();
    for (const auto& point : section.points) {
        if (point.verdict.reason == fitting::RejectReason::none) continue;
        Json rejected = place_of(point);
        rejected["reason"] = fitting::to_string(point.verdict.reason);
        points.push_back(std::move(rejected));
    }
    return points;
}

Json kept_points(const SectionResult& section) {
    Json points = Json::array();
    for (const auto& point : section.points)
        if (point.verdict.kept) points.push_back(place_of(point));
    return points;
}

Json compensation(const Compensation& compensation) {
    Json out{{"state", to_string(compensation.state)}, {"method", fitting::to_string(compensation.method())}};
    if (compensation.state == Compensation::State::final) {
        out["share"] = number(compensation.share);
        out["change_mm"] = number(compensation.from_flat_mm);
        if (fitting::is_point_by_point(compensation.asked)) out["set_aside"] = compensation.set_aside;
    }
    if (!compensation.note.empty()) out["why"] = compensation.note;
    return out;
}

/// Points of each pass over stretches of the section; empty: none.
Json measured_again(const SectionResult& section) {
    Json passes = Json::array();
    for (const auto& [pass, count] : points_of_passes(section))
        passes.push_back({{"pass", pass}, {"points", count}});
    return passes;
}

Json alignment(const Alignment& alignment) {
    Json out{{"state", to_string(alignment.state)}};
    if (alignment.state == Alignment::State::none) return out;
    const auto standard = [&](Eigen::Index k) { return number(alignment.standard(k)); };
    out["kind"] = to_string(alignment.spec.kind);
    if (alignment.spec.kind != AlignmentKind::six_points)
        out["objective"] = fitting::to_string(alignment.spec.objective);
    if (alignment.spec.kind != AlignmentKind::six_points) out["free"] = free_words(alignment.spec);
    if (alignment.done()) {
        const auto& motion = alignment.motion;
        out["about_x_mm"] = number(motion.about_mm.x());
        out["about_y_mm"] = number(motion.about_mm.y());
        out["shift_x_mm"] = number(motion.shift_mm.x());
        out["shift_x_standard_mm"] = standard(0);
        out["shift_y_mm"] = number(motion.shift_mm.y());
        out["shift_y_standard_mm"] = standard(1);
        out["turn_rad"] = number(motion.turn_rad);
        out["turn_standard_rad"] = standard(2);
        out["rms_mm"] = number(alignment.rms_mm);
        out["largest_mm"] = number(alignment.largest_mm);
        out["condition"] = number(alignment.condition);
        out["rounds"] = alignment.rounds;
        out["sections"] = alignment.sections;
    }
    if (!alignment.note.empty()) out["note"] = alignment.note;
    return out;
}

template <class Values>
Json list_of(const Values& values) {
    Json list = Json::array();
    for (const double value : values)
        list.push_back(number(value));
    return list;
}

Json part_frame(const fitting::SixPointFrame& frame) {
    Json excesses = Json::array();
    for (const auto& excess : frame.excess_mm)
        excesses.push_back(number(excess));
    Json rows = Json::array(), covariance = Json::array();
    for (Eigen::Index i = 0; i < 3; ++i)
        rows.push_back(list_of(Eigen::Vector4d(frame.machine_from_part.matrix().row(i).transpose())));
    for (Eigen::Index i = 0; i < 6; ++i)
        covariance.push_back(
            list_of(Eigen::Matrix<double, 6, 1>((frame.covariance + frame.shared).row(i).transpose())));
    return {{"kind", to_string(AlignmentKind::six_points)},
            {"machine_from_part", std::move(rows)},
            {"about_mm", list_of(frame.about_mm)},
            {"shift_mm", list_of(frame.shift_mm())},
            {"turn_rad", list_of(frame.turn_rad())},
            {"covariance", std::move(covariance)},
            {"touch_standard_mm", number(frame.touch_standard_mm)},
            {"residual_mm", list_of(frame.residual_mm)},
            {"excess_mm", std::move(excesses)},
            {"moved_mm", number(frame.moved_mm)},
            {"condition", number(frame.condition)},
            {"condition_length_mm", number(frame.length_mm)},
            {"rounds", frame.rounds}};
}

/// The figures that were used, and what they make as standard uncertainties.
Json uncertainty(const UncertaintySpec& spec) {
    Json figures = Json::object();
    const auto known = spec.figures();
    for (const auto& [name, figure] : drivers::machine_figures)
        figures[name] = number(known.*figure);
    const auto errors = spec.errors();
    return {{"figures", std::move(figures)},
            {"part_temperature_c", number(spec.part_temperature_c)},
            {"temperature_standard_k", number(spec.temperature_standard_k)},
            {"expansion_per_k", number(spec.expansion_per_k)},
            {"expansion_standard_per_k", number(spec.expansion_standard_per_k)},
            {"expansion_correction", to_string(spec.correction)},
            {"fixed_at_mm", list_of(spec.fixed_at_mm)},
            {"standard",
             {{"ball_mm", number(errors.ball_mm)},
              {"form_mm", number(errors.form_mm)},
              {"constant_mm", number(errors.constant_mm)},
              {"per_mm", number(errors.per_mm)},
              {"expansion", number(errors.expansion)}}},
            {"known_expansion", number(errors.known_expansion)}};
}

/// Between the points of the contour beside them.
Json gaps(const SectionResult& section) {
    Json out = Json::array();
    for (const auto& gap : section.gaps()) {
        const auto& contour = section.fit->contour;
        out.push_back({{"from_mm", list_of(contour[gap.before].position_mm)},
                       {"to_mm", list_of(contour[gap.behind].position_mm)},
                       {"length_mm", number(gap.length_mm)}});
    }
    return out;
}

Json section_of(const SectionResult& section) {
    Json characteristics = Json::array();
    for (const auto& c : section.characteristics)
        characteristics.push_back(characteristic(c));
    Json out{{"index", section.index},
             {"name", section.name},
             {"z_mm", number(section.z_mm)},
             {"points", section.points.size()},
             {"rejected", section.rejected()},
             {"closed", section.all_round()},
             {"decision", to_string(section.decision())},
             {"compensation", compensation(section.compensation)},
             {"alignment", alignment(section.alignment)}};
    if (auto again = measured_again(section); !again.empty()) out["measured_again"] = std::move(again);
    if (section.has_contour()) {
        out["contour_file"] = "section-" + std::to_string(section.index) + ".csv";
        out["noise_sigma_mm"] = number(section.fit->noise_sigma_mm);
        out["contour_points"] = std::count_if(section.fit->contour.begin(), section.fit->contour.end(),
                                              [](const auto& p) { return p.measured; });
        out["gaps"] = gaps(section);
        if (!section.deviation_mm.empty()) out["not_reached"] = section.not_reached();
    }
    if (!section.all_round()) out["why"] = section.why_not_all_round();
    out["characteristics"] = std::move(characteristics);
    out["rejected_points"] = rejected_points(section);
    if (auto kept = kept_points(section); !kept.empty()) out["kept_points"] = std::move(kept);
    return out;
}

Json traceability_of(const PartResult& part) {
    const auto known = [](const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); };
    Json sources = Json::array();
    for (const auto& source : part.sources)
        sources.push_back({{"what", source.what}, {"file", source.name}, {"sha256", known(source.sha256)}});
    const auto decisions = operator_decisions(part);
    return {{"sources", std::move(sources)},
            {"plan_hash", known(part.plan_hash)},
            {"points_csv_sha256", known(points_sha256(part))},
            {"left_out_by_operator", decisions.left_out},
            {"kept_by_operator", decisions.kept}};
}

}  // namespace

std::string result_json(const PartResult& part) {
    Json sections = Json::array();
    for (const auto& section : part.sections)
        sections.push_back(section_of(section));
    Json of_part = Json::array();
    for (const auto& [c, section] : part.characteristics) {
        of_part.push_back(characteristic(c));
        of_part.back()["section"] = section ? Json(*section) : Json(nullptr);
    }
    Json out{{"schema", "cmmlive-result"},
             {"schema_version", 1},
             {"verdict", verdict_word(part)},
             {"reasons", verdict_reasons(part)},
             {"decision_rule", part.decision_rule},
             {"part", {{"name", part.part_name}, {"serial", part.part_serial}, {"has_nominal", part.has_nominal}}},
             {"run",
              {{"id", part.run_id},
               {"started_utc", part.started_utc},
               {"machine", part.machine},
               {"software_version", part.software_version},
               {"ball_radius_mm", number(part.ball_radius_mm)},
               {"complete", part.complete}}},
             {"traceability", traceability_of(part)},
             {"characteristics", std::move(of_part)},
             {"sections", std::move(sections)}};
    if (part.uncertainty.errors().any()) out["uncertainty"] = uncertainty(part.uncertainty);
    if (part.part_frame) out["part_frame"] = part_frame(*part.part_frame);
    // Names come from files of the user: bytes that are not UTF-8 are replaced, not thrown at him.
    return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace cmm::acquisition
