// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/exports.hpp"
#include "acquisition/json_text.hpp"
#include "acquisition/part_body.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::app {
namespace {

/// A body says what it has of its part; other files have all that there is.
core::Result<std::optional<acquisition::WrittenBody>> write(const acquisition::PartResult& result,
                                                            const ExportOptions& options) {
    const std::string &format = options.format, &out = options.out;
    if (format == "stl") return acquisition::export_stl(result, out);
    if (format == "step") {
        const auto body = options.surface ? acquisition::PartBody::surface : acquisition::PartBody::solid;
        return acquisition::export_step(result, body, out);
    }
    const auto written = [&]() -> core::Status {
        if (format == "json") return acquisition::export_json(result, out);
        if (format == "html") return acquisition::export_html(result, out);
        if (format == "pdf") return acquisition::export_pdf(result, out);
        if (format == "dfq") return acquisition::export_dfq(result, out);
        if (format == "dmis") return acquisition::export_dmis(result, out);
        if (format == "png") return acquisition::export_png(result, out);
        if (format == "qif") return acquisition::export_qif(result, out);
        if (format == "svg") return acquisition::export_svg(result, out);
        std::error_code code;
        std::filesystem::create_directories(out, code);
        return acquisition::export_csv(result, out);
    }();
    if (!written) return tl::unexpected(written.error());
    return std::nullopt;
}

std::string why_not_taken(const acquisition::SectionResult& section) {
    if (!section.has_contour()) return section.why;
    return core::fixed(section.missing_mm(), 1) + " mm of it were not measured";
}

std::string names_of(const std::vector<const acquisition::SectionResult*>& sections) {
    std::string names;
    for (const auto* section : sections)
        names += (names.empty() ? "" : ", ") + acquisition::json_string(section->name);
    return "[" + names + "]";
}

std::string off_of(const acquisition::WrittenBody& body) {
    acquisition::JsonFields fields;
    fields.add("max", core::um_from_mm(body.off_max_mm), 3).add("rms", core::um_from_mm(body.off_rms_mm), 3);
    return "{" + fields.add("section", body.farthest->name).text() + "}";
}

void tell(const acquisition::WrittenBody& body) {
    for (const auto* section : body.passed_over)
        std::fprintf(stderr, "note: it passes over section %s: %s\n", section->name.c_str(),
                     why_not_taken(*section).c_str());
    std::fprintf(stderr, "measured contours are at most %s um off its surface (section %s; rms %s um)\n",
                 core::fixed(core::um_from_mm(body.off_max_mm), 3).c_str(), body.farthest->name.c_str(),
                 core::fixed(core::um_from_mm(body.off_rms_mm), 3).c_str());
}

}  // namespace

int run_export(const ExportOptions& options) {
    if (options.surface && options.format != "step") {
        return report(
            {core::ErrorCode::usage, "--surface goes with --format step only", {}, core::Motion::not_concerned},
            options.json);
    }
    const auto result = judge_input(options.input);
    if (!result) return report(result.error(), options.json);
    const auto body = write(*result, options);
    if (!body) return report(body.error(), options.json);
    if (options.json) {
        auto fields = acquisition::JsonFields().add("format", options.format).add("out", options.out);
        if (*body) {
            if (!(*body)->passed_over.empty()) fields.raw("passed_over", names_of((*body)->passed_over));
            fields.raw("contours_off_um", off_of(**body));
        }
        std::printf("{%s}\n", fields.text().c_str());
    } else {
        std::fprintf(stderr, "written: %s\n", options.out.c_str());
        if (*body) tell(**body);
    }
    return 0;
}

}  // namespace cmm::app
