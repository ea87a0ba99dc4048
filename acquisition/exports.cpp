// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exports.hpp"

#include <filesystem>
#include <system_error>

#include "acquisition/section_figures.hpp"
#include "acquisition/svg.hpp"
#include "core/text.hpp"
#include "pdf/png.hpp"

namespace cmm::acquisition {
namespace {

core::Status make_folder(const std::string& dir) {
    std::error_code error;
    std::filesystem::create_directories(dir, error);
    if (error) return core::fail(core::ErrorCode::journal_io, dir + ": cannot make the folder: " + error.message());
    return {};
}

constexpr int map_width_px = 2200;  // two pixels for one of the picture's

core::Result<std::string> map_of(const PartResult& part) {
    auto picture = map_figure(part);
    if (!picture.empty()) return picture;
    return core::fail(core::ErrorCode::input_invalid, part.part_name + ": no section is compared with a nominal");
}

}  // namespace

core::Status export_csv(const PartResult& part, const std::string& dir) {
    auto status = make_folder(dir);
    if (status) status = core::write_file(dir + "/sections.csv", sections_csv(part));
    if (status && !part.characteristics.empty()) status = core::write_file(dir + "/part.csv", part_csv(part));
    if (status) status = core::write_file(dir + "/points.csv", points_csv(part));
    if (status) status = core::write_file(dir + "/rejected.csv", rejected_csv(part));
    for (const auto& section : part.sections) {
        if (!status) return status;
        if (!section.has_contour()) continue;
        const auto file = dir + "/section-" + std::to_string(section.index) + ".csv";
        status = core::write_file(file, section_csv(section));
    }
    return status;
}

core::Status export_json(const PartResult& part, const std::string& file) {
    return core::write_file(file, result_json(part));
}

core::Status export_html(const PartResult& part, const std::string& file) {
    return core::write_file(file, report_html(part));
}

core::Status export_svg(const PartResult& part, const std::string& file) {
    const auto picture = map_of(part);
    if (!picture) return tl::unexpected(picture.error());
    return core::write_file(file, svg::standalone(*picture));
}

core::Status export_png(const PartResult& part, const std::string& file) {
    const auto picture = map_of(part);
    if (!picture) return tl::unexpected(picture.error());
    const auto bytes = pdf::png_of(svg::on_paper(*picture), map_width_px);
    if (!bytes) return tl::unexpected(bytes.error());
    return core::write_file(file, *bytes);
}

core::Status write_outputs(const PartResult& part, const std::string& dir) {
    auto status = export_csv(part, dir);
    if (status) status = export_json(part, dir + "/result.json");
    if (status) status = export_html(part, dir + "/report.html");
    return status;
}

}  // namespace cmm::acquisition
