// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>

#include "acquisition/exports.hpp"
#include "acquisition/json_text.hpp"
#include "acquisition/part_body.hpp"
#include "acquisition/run_results.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/run_input.hpp"

namespace cmm::app {
namespace {

core::Status write(const acquisition::PartResult& result, const ExportOptions& options) {
    const std::string &format = options.format, &out = options.out;
    if (format == "json") return acquisition::export_json(result, out);
    if (format == "html") return acquisition::export_html(result, out);
    if (format == "pdf") return acquisition::export_pdf(result, out);
    if (format == "dfq") return acquisition::export_dfq(result, out);
    if (format == "dmis") return acquisition::export_dmis(result, out);
    if (format == "png") return acquisition::export_png(result, out);
    if (format == "qif") return acquisition::export_qif(result, out);
    if (format == "svg") return acquisition::export_svg(result, out);
    if (format == "stl") return acquisition::export_stl(result, out);
    if (format == "step") {
        const auto body = options.surface ? acquisition::PartBody::surface : acquisition::PartBody::solid;
        return acquisition::export_step(result, body, out);
    }
    std::error_code code;
    std::filesystem::create_directories(out, code);
    return acquisition::export_csv(result, out);
}

}  // namespace

int run_export(const ExportOptions& options) {
    if (options.surface && options.format != "step") {
        return report(
            {core::ErrorCode::usage, "--surface goes with --format step only", {}, core::Motion::not_concerned},
            options.json);
    }
    const auto result = acquisition::results_of_run(run_file_of(options.input), nullptr);
    if (!result) return report(result.error(), options.json);
    if (auto status = write(*result, options); !status) return report(status.error(), options.json);
    if (options.json) {
        std::printf("{%s}\n",
                    acquisition::JsonFields().add("format", options.format).add("out", options.out).text().c_str());
    } else {
        std::fprintf(stderr, "written: %s\n", options.out.c_str());
    }
    return 0;
}

}  // namespace cmm::app
