// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/journal.hpp"
#include "core/error.hpp"
#include "core/sample.hpp"

namespace cmm::acquisition {

/// The samples of a run file as a tape: read once, played from one end to the other. Sample k of the tape has sequence
/// k + 1. One owner, no locking.
class Recording {
  public:
    /// Errors: journal_io, journal_corrupt (also: a sample of a path that was never begun).
    static core::Result<Recording> load(const std::string& file);

    const Journal::Header& header() const { return header_; }
    const std::map<std::string, double>& part_frame() const { return part_frame_; }
    std::uint64_t size() const { return samples_.size(); }
    /// How many samples have been played.
    std::uint64_t position() const { return position_; }
    /// Goes on after sample `sequence`, which is not larger than size().
    void go_to(std::uint64_t sequence) { position_ = sequence; }

    /// The touches that come next in a row.
    std::span<const core::Sample> touches() const;
    /// The samples that come next in a row and belong to this section.
    std::span<const core::Sample> of_section(std::size_t section) const;
    /// The section that comes next, touches passed over; nothing at the end of the tape.
    std::optional<std::size_t> next_section() const;
    void played(std::size_t count) { position_ += count; }

  private:
    bool is_touch(std::uint64_t at) const;
    Journal::Header header_;
    std::map<std::string, double> part_frame_;
    std::vector<core::Sample> samples_;
    std::vector<std::uint32_t> section_of_path_;  // by path id; no_section: never begun
    std::uint64_t position_ = 0;
};

}  // namespace cmm::acquisition
