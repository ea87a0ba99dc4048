// SPDX-License-Identifier: Apache-2.0
#include "acquisition/recording.hpp"

#include <limits>
#include <utility>

namespace cmm::acquisition {
namespace {

constexpr std::uint32_t no_section = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t path_ids = std::size_t{std::numeric_limits<std::uint16_t>::max()} + 1;

}  // namespace

core::Result<Recording> Recording::load(const std::string& file) {
    const auto journal = Journal::read(file);
    if (!journal) return tl::unexpected(journal.error());
    const auto paths = (*journal)->paths();
    if (!paths) return tl::unexpected(paths.error());
    auto samples = (*journal)->samples();
    if (!samples) return tl::unexpected(samples.error());
    auto frame = (*journal)->part_frame();
    if (!frame) return tl::unexpected(frame.error());
    Recording recording;
    recording.header_ = (*journal)->header();
    recording.part_frame_ = std::move(*frame);
    recording.section_of_path_.assign(path_ids, no_section);
    for (const auto& path : *paths)
        recording.section_of_path_[path.path] = static_cast<std::uint32_t>(path.section);
    recording.samples_ = std::move(*samples);
    for (std::uint64_t at = 0; at < recording.size(); ++at) {
        const auto& sample = recording.samples_[at];
        if (recording.is_touch(at) || recording.section_of_path_[sample.path] != no_section) continue;
        return core::fail(core::ErrorCode::journal_corrupt, file + ": sample " + std::to_string(sample.sequence) +
                                                                " belongs to path " + std::to_string(sample.path) +
                                                                ", which was never begun");
    }
    return recording;
}

bool Recording::is_touch(std::uint64_t at) const {
    return (samples_[at].flags & core::sample_flag::touch) != 0;
}

std::span<const core::Sample> Recording::touches() const {
    std::uint64_t end = position_;
    while (end < size() && is_touch(end))
        ++end;
    return std::span(samples_).subspan(position_, end - position_);
}

std::span<const core::Sample> Recording::of_section(std::size_t section) const {
    std::uint64_t end = position_;
    while (end < size() && !is_touch(end) && section_of_path_[samples_[end].path] == section)
        ++end;
    return std::span(samples_).subspan(position_, end - position_);
}

std::optional<std::size_t> Recording::next_section() const {
    const std::uint64_t at = position_ + touches().size();
    if (at >= size()) return std::nullopt;
    return section_of_path_[samples_[at].path];
}

}  // namespace cmm::acquisition
