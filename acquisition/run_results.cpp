// SPDX-License-Identifier: Apache-2.0
#include "acquisition/run_results.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "acquisition/section_setup.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

RecordedPoint recorded(const core::Sample& sample, double lsb_mm) {
    RecordedPoint point;
    point.sequence = sample.sequence;
    point.flags = sample.flags;
    point.centre_mm = core::centre_mm(sample, lsb_mm);
    if ((sample.flags & core::sample_flag::no_contact) != 0) point.verdict.reason = fitting::RejectReason::no_contact;
    return point;
}

/// Height of a recorded section: the plan's where the part file has it, else the mean of the points.
double height_of(const RecordedSection& section, const PartFile& part) {
    if (section.index < part.scan.heights_mm.size()) return part.scan.heights_mm[section.index];
    double sum = 0.0;
    for (const auto& point : section.points)
        sum += point.centre_mm.z();
    return section.points.empty() ? 0.0 : sum / static_cast<double>(section.points.size());
}

/// Points scatter in z with the probe's noise: a section that lies on a height of the plan is at that height.
double planned_height(double z_mm, const std::vector<double>& heights_mm) {
    constexpr double scatter_mm = 0.02;
    for (const double height : heights_mm) {
        if (std::abs(height - z_mm) <= scatter_mm) return height;
    }
    return z_mm;
}

core::Result<PartFile> kept_part(const Journal::Header& header, const std::string& run_file) {
    auto part = parse_part_file(header.part_text, header.part_path);
    if (!part) return tl::unexpected(std::move(part.error()).with_context("the part file kept in " + run_file));
    return part;
}

}  // namespace

core::Result<PartFile> part_of_run(const std::string& run_file) {
    const auto journal = Journal::read(run_file);
    if (!journal) return tl::unexpected(journal.error());
    return kept_part((*journal)->header(), run_file);
}

core::Result<std::vector<RecordedSection>> recorded_sections(const Journal& journal) {
    const auto paths = journal.paths();
    if (!paths) return tl::unexpected(paths.error());
    std::map<std::uint16_t, std::size_t> section_of_path;
    std::map<std::size_t, RecordedSection> sections;
    for (const auto& path : *paths) {
        section_of_path[path.path] = path.section;
        auto& section = sections[path.section];
        section.index = path.section;
        section.finished = section.finished || path.finished;
        section.last_path = std::max(section.last_path, path.path);
    }
    const double lsb_mm = journal.header().lsb_mm;
    const auto status = journal.each_batch([&](std::span<const core::Sample> batch) -> core::Status {
        for (const auto& sample : batch) {
            if (!core::of_section(sample)) continue;
            const auto found = section_of_path.find(sample.path);
            if (found == section_of_path.end()) {
                return core::fail(core::ErrorCode::journal_corrupt,
                                  "sample " + std::to_string(sample.sequence) + " belongs to path " +
                                      std::to_string(sample.path) + ", which was never begun");
            }
            sections[found->second].points.push_back(recorded(sample, lsb_mm));
        }
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    std::vector<RecordedSection> ordered;
    for (auto& [index, section] : sections)
        ordered.push_back(std::move(section));
    return ordered;
}

core::Result<PartResult> results_of_run(const std::string& run_file, const PartFile* part, OperatorChoice choice) {
    auto journal = Journal::read(run_file);
    if (!journal) return tl::unexpected(journal.error());
    const auto& header = (*journal)->header();
    auto own = kept_part(header, run_file);
    if (part == nullptr) {
        if (!own) return tl::unexpected(own.error());
        part = &*own;
    }
    const auto nominal = load_nominal(part->nominal);
    if (!nominal) return tl::unexpected(nominal.error());
    auto recorded = recorded_sections(**journal);
    if (!recorded) return tl::unexpected(recorded.error());

    PartResult result;
    result.part_name = part->name;
    result.part_serial = part->serial;
    result.started_utc = header.started_utc;
    result.machine = header.machine_model + " " + header.machine_serial + " (" + header.machine_url + ")";
    result.run_id = header.run_id;
    result.software_version = header.software_version;
    result.ball_radius_mm = header.ball_radius_mm;
    result.has_nominal = *nominal != nullptr;
    result.complete = recorded->size() == part->scan.heights_mm.size();
    PartFile measured = *part;
    measured.stylus.radius_mm = header.ball_radius_mm;  // the ball that measured, whatever a second part file says
    SectionJudge judge;
    for (auto& section : *recorded) {
        choice.apply(section.points);
        auto setup = make_section_setup(measured, nominal->get(), section.index, height_of(section, measured));
        if (!setup) return tl::unexpected(setup.error());
        result.complete = result.complete && section.finished;
        result.sections.push_back(judge.finish(*setup, std::move(section.points)));
    }
    if (auto status = choice.all_found(); !status) return tl::unexpected(status.error());
    return result;
}

core::Result<PartResult> results_of_points(const std::vector<PointSection>& sections, double ball_radius_mm,
                                           const PartFile* part, OperatorChoice choice) {
    PartFile bare;
    bare.name = "points";
    PartFile used = part != nullptr ? *part : bare;
    used.stylus.radius_mm = ball_radius_mm;
    const auto nominal = load_nominal(used.nominal);
    if (!nominal) return tl::unexpected(nominal.error());
    PartResult result;
    result.part_name = used.name;
    result.part_serial = used.serial;
    result.machine = "recorded points";
    result.ball_radius_mm = ball_radius_mm;
    result.has_nominal = *nominal != nullptr;
    std::uint64_t sequence = 0;
    SectionJudge judge;
    for (std::size_t i = 0; i < sections.size(); ++i) {
        auto setup =
            make_section_setup(used, nominal->get(), i, planned_height(sections[i].z_mm(), used.scan.heights_mm));
        if (!setup) return tl::unexpected(setup.error());
        setup->name = sections[i].name;
        std::vector<RecordedPoint> points;
        points.reserve(sections[i].points_mm.size());
        for (std::size_t k = 0; k < sections[i].points_mm.size(); ++k) {
            RecordedPoint point;
            point.sequence = sections[i].sequences.empty() ? ++sequence : sections[i].sequences[k];
            point.centre_mm = sections[i].points_mm[k];
            point.flags = sections[i].flags.empty() ? std::uint16_t{0} : sections[i].flags[k];
            if ((point.flags & core::sample_flag::no_contact) != 0)
                point.verdict.reason = fitting::RejectReason::no_contact;
            points.push_back(point);
        }
        choice.apply(points);
        result.sections.push_back(judge.finish(*setup, std::move(points)));
    }
    if (auto status = choice.all_found(); !status) return tl::unexpected(status.error());
    return result;
}

}  // namespace cmm::acquisition
