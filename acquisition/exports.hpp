// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "acquisition/section_result.hpp"
#include "core/error.hpp"

/// The files of the contract (docs/outputs.md). Text functions are pure; millimetres, part frame, unit in every column
/// name.
namespace cmm::acquisition {

/// One row a section.
std::string sections_csv(const PartResult& part);
/// One row a characteristic that needs several sections; angles in degrees.
std::string part_csv(const PartResult& part);
/// The part contour: closed (last row joins the first), counter-clockwise seen from +Z. Empty without a closed fit.
std::string section_csv(const SectionResult& section);
/// Every recorded point of every section, used or not, in the form that `cmmlive fit` reads.
std::string points_csv(const PartResult& part);
/// Every point that was not used, with its reason.
std::string rejected_csv(const PartResult& part);
/// result.json
std::string result_json(const PartResult& part);
/// report.html: one file, nothing from outside.
std::string report_html(const PartResult& part);
/// The report on A4 pages. Errors: config_invalid (this build writes no PDF, no font is installed).
core::Result<std::string> report_pdf(const PartResult& part);
/// A QIF 3.0 document (ISO 23952) with what was asked for and what was measured, millimetres; the uncertainty of a
/// value is the combined standard one, U95/2.
std::string qif_xml(const PartResult& part);
/// Q-DAS AQDEF, description and values in K fields: every characteristic of every section once.
std::string dfq_text(const PartResult& part);
/// DMIS output (ISO 22093): sections and edges as features, what has limits as tolerances with deviations; millimetres
/// and degrees.
std::string dmis_output(const PartResult& part);
/// The table that ends a run in a terminal, then the verdict with a line for every cause.
std::string summary_text(const PartResult& part);
/// "accept", "reject", "undecided", or "done" for a part without requirements.
std::string verdict_word(const PartResult& part);

core::Status export_csv(const PartResult& part, const std::string& dir);
core::Status export_json(const PartResult& part, const std::string& file);
core::Status export_html(const PartResult& part, const std::string& file);
core::Status export_pdf(const PartResult& part, const std::string& file);
core::Status export_dfq(const PartResult& part, const std::string& file);
core::Status export_dmis(const PartResult& part, const std::string& file);
core::Status export_qif(const PartResult& part, const std::string& file);
/// The map of deviations as a picture of its own. Errors also: input_invalid (no section is compared with a nominal).
core::Status export_svg(const PartResult& part, const std::string& file);
/// The same with 2 200 pixels in a row, light. Errors also: config_invalid (this build writes no PNG, no font is
/// installed).
core::Status export_png(const PartResult& part, const std::string& file);
/// All of them into `dir`, which is made when it is not there. Errors: journal_io, journal_full.
core::Status write_outputs(const PartResult& part, const std::string& dir);

}  // namespace cmm::acquisition
