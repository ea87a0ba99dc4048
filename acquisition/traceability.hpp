// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquisition/part_file.hpp"
#include "acquisition/section_result.hpp"

/// What a result rests on, so that whoever reads it later can tell whether it was this: the files that say what is
/// measured and how it is judged, the plan, the points as they came, and what people decided about them. A hash that
/// cannot be had is left empty and shown as unknown: it never stands in the way of a result.
namespace cmm::acquisition {

/// 64 small hex digits, as `sha256sum` prints them (FIPS 180-4, by libcrypto).
std::string sha256(std::string_view bytes);
SourceFile source_file(const std::string& what, const std::string& path);
/// The part file as it was read, the files of its nominal and its tolerance file as they are now.
std::vector<SourceFile> sources_of(const PartFile& part);
/// Of `points.csv`.
std::string points_sha256(const PartResult& part);
/// Points that the evaluation would have used and a person left out, and the other way round.
struct OperatorDecisions {
    std::size_t left_out = 0, kept = 0;
};
OperatorDecisions operator_decisions(const PartResult& part);
/// Name and text, for reports.
std::vector<std::pair<std::string, std::string>> traceability(const PartResult& part);

}  // namespace cmm::acquisition
