// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquisition/section_result.hpp"

/// What every report says in words, whatever it is written in. UTF-8, nothing escaped.
namespace cmm::acquisition {

/// A characteristic that every section has, with its title.
struct ReportTerm {
    std::string_view name, title;
};
/// Those that any section of the part has.
std::vector<ReportTerm> report_terms(const PartResult& part);

/// Name and value: serial number, machine, run, stylus, reference, points, software; those that are known.
std::vector<std::pair<std::string, std::string>> report_facts(const PartResult& part);
/// "2 of 8 sections outside tolerance"
std::string verdict_detail(const PartResult& part);
/// The reasons of the verdict with real signs: "±", no break inside an inequality.
std::vector<std::string> typeset_reasons(const PartResult& part);
/// "Section 3, z = 40.000 mm"
std::string title_of(const SectionResult& section);
/// Points, scatter and how the ball was compensated.
std::string summary_of(const SectionResult& section);
/// Of one that was not measured all round: what is missing.
std::string not_all_round_text(const SectionResult& section);
/// "not evaluable"
std::string words(Decision decision);
/// "Accept"
std::string capital(std::string text);
/// Name and text: the method of each characteristic, then of decision, uncertainty, compensation and rejected points.
std::vector<std::pair<std::string, std::string>> report_methods(const PartResult& part);
/// The first of any section.
const Characteristic* first_of(const PartResult& part, std::string_view name);

}  // namespace cmm::acquisition
