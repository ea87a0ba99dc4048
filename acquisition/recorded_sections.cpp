// SPDX-License-Identifier: Apache-2.0
#include "acquisition/recorded_sections.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "acquisition/part_frame.hpp"

namespace cmm::acquisition {
namespace {

RecordedPoint recorded(const core::Sample& sample, double lsb_mm, const core::PartFromMachine& to_part) {
    RecordedPoint point;
    point.sequence = sample.sequence;
    point.flags = sample.flags;
    point.centre_mm = to_part(core::Position<core::MachineFrame>{core::centre_mm(sample, lsb_mm)}).mm;
    if ((sample.flags & core::sample_flag::no_contact) != 0) point.verdict.reason = fitting::RejectReason::no_contact;
    return point;
}

}  // namespace

RecordedSection& RecordedSections::section(std::size_t index) {
    const auto place = std::lower_bound(sections_.begin(), sections_.end(), index,
                                        [](const RecordedSection& known, std::size_t at) { return known.index < at; });
    if (place != sections_.end() && place->index == index) return *place;
    RecordedSection fresh;
    fresh.index = index;
    return *sections_.insert(place, std::move(fresh));
}

core::Status RecordedSections::refresh(const Journal& journal) {
    // A file that is being written grows between these readings: a path finished in the first has all its samples in
    // the second, whose paths are all in the third.
    const auto before = journal.paths();
    if (!before) return tl::unexpected(before.error());
    std::vector<core::Sample> samples;
    const auto status = journal.each_batch_from(last_sequence_ + 1, [&](std::span<const core::Sample> batch) {
        for (const auto& sample : batch) {
            if (sample.sequence > last_sequence_ && core::of_section(sample)) samples.push_back(sample);
        }
        if (!batch.empty()) last_sequence_ = std::max(last_sequence_, batch.back().sequence);
        return core::Status{};
    });
    if (!status) return status;
    const auto paths = journal.paths();
    if (!paths) return tl::unexpected(paths.error());
    // Found before the first path begins.
    const auto numbers = journal.part_frame();
    if (!numbers) return tl::unexpected(numbers.error());
    const auto frame = frame_from_numbers(*numbers);
    if (!frame) return tl::unexpected(frame.error());
    const auto to_part = part_from_machine(*frame);
    for (const auto& path : *paths)
        section_of_path_[path.path] = {path.section, path.pass};
    for (const auto& path : *before) {
        auto& of_path = section(path.section);
        of_path.finished = of_path.finished || path.finished;
        of_path.last_path = std::max(of_path.last_path, path.path);
    }
    for (const auto& sample : samples) {
        const auto found = section_of_path_.find(sample.path);
        if (found == section_of_path_.end()) {
            return core::fail(core::ErrorCode::journal_corrupt, "sample " + std::to_string(sample.sequence) +
                                                                    " belongs to path " + std::to_string(sample.path) +
                                                                    ", which was never begun");
        }
        const auto [index, pass] = found->second;
        auto& points = section(index).points;
        points.push_back(recorded(sample, journal.header().lsb_mm, to_part));
        points.back().pass = pass;
    }
    return {};
}

core::Result<std::vector<RecordedSection>> recorded_sections(const Journal& journal) {
    RecordedSections sections;
    if (auto status = sections.refresh(journal); !status) return tl::unexpected(status.error());
    return sections.take();
}

}  // namespace cmm::acquisition
