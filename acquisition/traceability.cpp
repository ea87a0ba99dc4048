// SPDX-License-Identifier: Apache-2.0
#include "acquisition/traceability.hpp"

#include <openssl/evp.h>

#include <array>
#include <filesystem>

#include "acquisition/exports.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

std::string file_name(const std::string& path) {
    return std::filesystem::path(path).filename().string();
}

std::string worded(const std::string& sha256) {
    return sha256.empty() ? "SHA-256 unknown: it could not be read" : "SHA-256 " + sha256;
}

}  // namespace

std::string sha256(std::string_view bytes) {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned size = 0;
    if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) return {};
    std::string text;
    for (std::size_t i = 0; i < size; ++i) {
        text += "0123456789abcdef"[digest[i] >> 4U];
        text += "0123456789abcdef"[digest[i] & 0xFU];
    }
    return text;
}

SourceFile source_file(const std::string& what, const std::string& path) {
    const auto content = core::read_file(path);
    return {what, file_name(path), content ? sha256(*content) : ""};
}

std::vector<SourceFile> sources_of(const PartFile& part) {
    std::vector<SourceFile> sources;
    if (!part.text.empty()) sources.push_back({"Part file", file_name(part.path), sha256(part.text)});
    for (const auto& path : part.nominal.files)
        sources.push_back(source_file("Nominal", path));
    if (!part.tolerance.file.empty()) sources.push_back(source_file("Tolerances", part.tolerance.file));
    return sources;
}

std::string points_sha256(const PartResult& part) {
    return sha256(points_csv(part));
}

OperatorDecisions operator_decisions(const PartResult& part) {
    OperatorDecisions decisions;
    for (const auto& section : part.sections)
        for (const auto& point : section.points) {
            if (point.verdict.reason == fitting::RejectReason::by_operator) ++decisions.left_out;
            if (point.verdict.kept) ++decisions.kept;
        }
    return decisions;
}

std::vector<std::pair<std::string, std::string>> traceability(const PartResult& part) {
    std::vector<std::pair<std::string, std::string>> facts;
    for (const auto& source : part.sources)
        facts.emplace_back(source.what, source.name + ", " + worded(source.sha256));
    if (!part.plan_hash.empty()) facts.emplace_back("Plan", "hash " + part.plan_hash);
    facts.emplace_back("Points", "points.csv, " + worded(points_sha256(part)));
    const auto decisions = operator_decisions(part);
    facts.emplace_back("Decisions of people", decisions.left_out + decisions.kept == 0
                                                  ? "none"
                                                  : "points left out: " + std::to_string(decisions.left_out) +
                                                        ", kept: " + std::to_string(decisions.kept));
    return facts;
}

}  // namespace cmm::acquisition
