// SPDX-License-Identifier: Apache-2.0
#include "web/server/documents.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "acquisition/budget_table.hpp"
#include "acquisition/exports.hpp"
#include "acquisition/json_text.hpp"
#include "acquisition/run_file.hpp"
#include "core/text.hpp"
#include "web/server/choice_request.hpp"

namespace cmm::web {
namespace {

using acquisition::JsonFields;
using acquisition::RunReview;
using nlohmann::json;

constexpr int place_digits = 4;
constexpr int deviation_digits = 5;
constexpr std::size_t most_points = 20'000;
constexpr std::size_t most_nominal_points = 2'000;

/// A JSON array, element by element.
class Row {
  public:
    Row& add(double value, int digits) { return raw(std::isfinite(value) ? core::fixed(value, digits) : "null"); }
    Row& add(const std::optional<double>& value, int digits) { return value ? add(*value, digits) : raw("null"); }
    Row& add(const Eigen::Vector2d& place) { return add(place.x(), place_digits).add(place.y(), place_digits); }
    Row& raw(std::string_view text) {
        text_ += text_.size() > 1 ? "," : "";
        text_ += text;
        return *this;
    }
    std::string text() const { return text_ + "]"; }

  private:
    std::string text_ = "[";
};

std::string nominal_row(const acquisition::SectionSetup& setup) {
    Row row;
    if (!setup.nominal) return row.text();
    const auto& points = setup.nominal->reference.points();
    const std::size_t stride = points.size() / most_nominal_points + 1;
    for (std::size_t i = 0; i < points.size(); i += stride)
        row.add(points[i]);
    return row.text();
}

std::size_t planned_sections(const RunReview& review) {
    const auto& recorded = review.recorded().all();
    const std::size_t seen = recorded.empty() ? 0 : recorded.back().index + 1;
    return std::max(review.part().scan.heights_mm.size(), seen);
}

/// The nominal's distance at a ball centre, provisional: the ball's radius along the normal, no side told apart.
Row point_row(const acquisition::RecordedPoint& point, const acquisition::SectionSetup& setup,
              std::optional<double>& hint) {
    Row row;
    row.raw(std::to_string(point.sequence)).raw(std::to_string(setup.index)).add(point.centre_mm.head<2>());
    const bool touched = point.verdict.reason != fitting::RejectReason::no_contact;
    row.raw(touched ? "1" : "0");
    if (!setup.nominal || !touched) return row;
    const auto foot = setup.nominal->section.curve().closest(point.centre_mm.head<2>(), hint);
    hint = foot.s_mm;
    const auto normal = setup.nominal->section.curve().evaluate(foot.s_mm).normal;
    row.add(foot.distance_mm - setup.ball_radius_mm, deviation_digits).add(normal);
    return row;
}

std::string contour_rows(const acquisition::SectionResult& section) {
    Row rows;
    if (!section.has_contour()) return rows.text();
    const auto& contour = section.fit->contour;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        Row row;
        row.add(contour[i].position_mm).add(contour[i].normal);
        row.raw(std::to_string(static_cast<int>(contour[i].zone)));
        row.add(section.deviation_mm.empty() ? std::nullopt : section.deviation_mm[i], deviation_digits);
        row.add(contour[i].measured ? std::optional(section.deviation_u95_mm(i)) : std::nullopt, deviation_digits);
        if (!section.tolerances.empty())
            row.add(section.tolerances[i].below_mm, deviation_digits)
                .add(section.tolerances[i].above_mm, deviation_digits);
        rows.raw(row.text());
    }
    return rows.text();
}

std::string nose_row(const acquisition::SectionResult& section, fitting::Zone edge) {
    const auto nose = section.nose_mm(edge);
    return nose ? Row().add(*nose).text() : "null";
}

std::string judged_rows(const acquisition::SectionResult& section) {
    Row rows;
    for (const auto& point : section.points) {
        Row row;
        row.raw(std::to_string(point.sequence)).add(point.centre_mm.head<2>());
        row.raw(acquisition::json_string(point.verdict.kept ? std::string_view("kept")
                                                            : fitting::to_string(point.verdict.reason)));
        row.add(point.verdict.residual_mm, deviation_digits);
        rows.raw(row.text());
    }
    return rows.text();
}

std::string budget_object(const fitting::ErrorBudget& budget) {
    JsonFields fields;
    const auto parts = acquisition::parts_of(budget);
    for (std::size_t k = 0; k < parts.size(); ++k)
        fields.add(acquisition::budget_words.at(k).key, parts.at(k), 9);
    return "{" + fields.text() + "}";
}

std::string characteristic_rows(const acquisition::SectionResult& section) {
    Row rows;
    for (const auto& c : section.characteristics) {
        JsonFields fields;
        fields.add("name", c.name)
            .add("value_mm", in_mm(c, c.value), 6)
            .add("u95_mm", in_mm(c, c.u95), 6)
            .add("limit_mm", in_mm(c, c.upper), 6)
            .add("unit", acquisition::to_string(c.unit))
            .add("value", c.value, 9)
            .add("u95", c.u95, 9)
            .add("nominal", c.nominal, 9)
            .add("lower", c.lower, 9)
            .add("upper", c.upper, 9)
            .add("decision", acquisition::to_string(c.decision))
            .add("method", c.method)
            .add("note", c.note);
        if (c.budget) fields.raw("budget", budget_object(*c.budget));
        rows.raw("{" + fields.text() + "}");
    }
    return rows.text();
}

json read_json(const std::string& file) {
    const auto text = core::read_file(file);
    return text ? json::parse(*text, nullptr, false) : json(json::value_t::discarded);
}

/// The worst value of every characteristic over the sections: nearest to or furthest beyond its limit.
json worst_of(const json& sections) {
    json worst = json::object();
    for (const auto& section : sections) {
        for (const auto& c : section.value("characteristics", json::array())) {
            if (!c.is_object() || !c.value("value_mm", json()).is_number() || !c.value("name", json()).is_string())
                continue;
            auto& known = worst[c["name"].get<std::string>()];
            if (!known.is_null() && known["value_mm"].get<double>() >= c["value_mm"].get<double>()) continue;
            known = {{"value_mm", c["value_mm"]},
                     {"u95_mm", c.value("u95_mm", json())},
                     {"limit_mm", c.value("limit_mm", json())},
                     {"decision", c.value("decision", json())},
                     {"section", section.value("index", json())}};
        }
    }
    return worst;
}

json summary_of_result(const json& result) {
    const json part = result.value("part", json::object());
    const json run = result.value("run", json::object());
    const json sections = result.value("sections", json::array());
    return {{"part", part.value("name", json())},
            {"serial", part.value("serial", json())},
            {"started_utc", run.value("started_utc", json())},
            {"machine", run.value("machine", json())},
            {"complete", run.value("complete", json())},
            {"verdict", result.value("verdict", json())},
            {"sections", sections.size()},
            {"worst", worst_of(sections)}};
}

json summary_of_run_file(const acquisition::Journal::Header& header) {
    return {{"started_utc", header.started_utc}, {"machine", header.machine_model}, {"complete", false}};
}

core::Result<acquisition::Journal::Header> header_of(const std::string& run_file) {
    const auto opened = acquisition::RunFile::open(run_file, acquisition::RunFile::Access::read);
    if (!opened) return tl::unexpected(opened.error());
    return (*opened)->header();
}

/// result.json may be that of an earlier run in the same folder.
bool is_of(const json& result, const std::string& run_id) {
    if (!result.is_object() || !result.contains("run") || !result["run"].is_object()) return false;
    return result["run"].value("id", json()) == run_id;
}

}  // namespace

core::Result<std::string> plan_document(const std::string& id, RunReview& review) {
    Row sections;
    for (std::size_t i = 0; i < planned_sections(review); ++i) {
        const auto setup = review.setup(i);
        if (!setup) return tl::unexpected(setup.error());
        JsonFields fields;
        fields.add("index", i).add("z_mm", (*setup)->z_mm, place_digits).raw("nominal", nominal_row(**setup));
        sections.raw("{" + fields.text() + "}");
    }
    const auto& header = review.journal().header();
    return "{" +
           JsonFields()
               .add("id", id)
               .add("run_id", header.run_id)
               .add("part", review.part().name)
               .add("serial", review.part().serial)
               .add("machine", header.machine_model + " " + header.machine_serial)
               .add("started_utc", header.started_utc)
               .add("has_nominal", review.has_nominal())
               .add("ball_radius_mm", header.ball_radius_mm, place_digits)
               .add("profile_mm", review.part().gate.profile_mm, deviation_digits)
               .add("edge_profile_mm", review.part().gate.edge_profile_mm, deviation_digits)
               .raw("sections", sections.text())
               .text() +
           "}\n";
}

core::Result<std::string> points_document(RunReview& review, std::uint64_t after) {
    // Sections take turns when a run is resumed: the oldest points first, whichever section they are of.
    struct Found {
        const acquisition::RecordedPoint* point;
        std::size_t section;
    };
    std::vector<Found> found;
    for (const auto& section : review.recorded().all()) {
        const auto& points = section.points;
        auto next =
            std::upper_bound(points.begin(), points.end(), after,
                             [](std::uint64_t sequence, const auto& point) { return sequence < point.sequence; });
        for (; next != points.end(); ++next)
            found.push_back({&*next, section.index});
    }
    std::sort(found.begin(), found.end(),
              [](const Found& a, const Found& b) { return a.point->sequence < b.point->sequence; });
    const bool more = found.size() > most_points;
    if (more) found.resize(most_points);
    Row rows;
    std::optional<double> hint;
    std::size_t hinted = 0;
    for (const auto& [point, section] : found) {
        const auto setup = review.setup(section);
        if (!setup) return tl::unexpected(setup.error());
        if (std::exchange(hinted, section) != section) hint.reset();
        rows.raw(point_row(*point, **setup, hint).text());
    }
    const std::uint64_t last = more ? found.back().point->sequence : std::max(after, review.recorded().last_sequence());
    return "{" + JsonFields().add("last", last).add("more", more).raw("points", rows.text()).text() + "}\n";
}

core::Result<std::string> section_document(RunReview& review, std::size_t index) {
    const auto& sections = review.recorded().all();
    const auto found =
        std::find_if(sections.begin(), sections.end(), [&](const auto& known) { return known.index == index; });
    if (found == sections.end()) {
        return core::fail(core::ErrorCode::input_missing,
                          "section " + std::to_string(index) + " has not been measured");
    }
    const auto judged = review.result_at(static_cast<std::size_t>(found - sections.begin()));
    if (!judged) return tl::unexpected(judged.error());
    const auto& section = **judged;
    JsonFields fields;
    fields.add("index", section.index)
        .add("name", section.name)
        .add("z_mm", section.z_mm, place_digits)
        .add("finished", found->finished)
        .add("closed", section.all_round())
        .add("decision", acquisition::to_string(section.decision()))
        .add("rejected", section.rejected())
        .add("why", section.why_not_all_round());
    if (section.has_contour()) {
        fields.add("noise_mm", section.fit->noise_sigma_mm, 6)
            .raw("le", nose_row(section, fitting::Zone::le))
            .raw("te", nose_row(section, fitting::Zone::te));
    }
    fields.raw("characteristics", characteristic_rows(section))
        .raw("contour", contour_rows(section))
        .raw("points", judged_rows(section));
    return "{" + fields.text() + "}\n";
}

core::Result<std::string> result_document(const std::string& id, RunReview& review) {
    const auto result = review.result();
    if (!result) return tl::unexpected(result.error());
    return "{" +
           JsonFields()
               .add("id", id)
               .raw("choice", choice_document(review.choice()))
               .raw("result", acquisition::result_json(*result))
               .text() +
           "}\n";
}

std::string summary_document(const std::string& id, const std::string& folder) {
    json summary;
    const auto header = header_of(folder + "/run.cmmrun");
    try {
        const json result = read_json(folder + "/result.json");
        if (!header) {
            summary = {{"problem", header.error().text()}};
        } else {
            summary = is_of(result, header->run_id) ? summary_of_result(result) : summary_of_run_file(*header);
        }
    } catch (const json::exception&) {
        summary = {{"problem", "result.json is none of cmmlive"}};
    }
    summary["id"] = id;
    return summary.dump(-1, ' ', false, json::error_handler_t::replace);
}

acquisition::OperatorChoice recorded_choice(const std::string& folder, const std::string& run_id) {
    acquisition::OperatorChoice choice;
    const json result = read_json(folder + "/result.json");
    if (!is_of(result, run_id) || !result.contains("sections")) return choice;
    for (const auto& section : result["sections"]) {
        if (!section.is_object()) continue;
        for (const auto& point : section.value("rejected_points", json::array())) {
            if (point.is_object() && point.value("reason", json()) == "by_operator" &&
                point.value("seq", json()).is_number_unsigned())
                choice.reject(point["seq"].get<std::uint64_t>());
        }
        for (const auto& point : section.value("kept_points", json::array()))
            if (point.is_object() && point.value("seq", json()).is_number_unsigned())
                choice.restore(point["seq"].get<std::uint64_t>());
    }
    return choice;
}

}  // namespace cmm::web
