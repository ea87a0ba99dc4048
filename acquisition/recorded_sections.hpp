// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "acquisition/journal.hpp"
#include "acquisition/section_result.hpp"
#include "core/error.hpp"

namespace cmm::acquisition {

/// The samples of one section as the run file holds them, in order, over all paths that measured it.
struct RecordedSection {
    std::size_t index = 0;
    bool finished = false;  ///< its last path came to its end
    std::uint16_t last_path = 0;
    std::vector<RecordedPoint> points;  ///< part frame; touches are left out
};

/// The sections of a run file, by index, also of one that is still written: `refresh` reads what was added since.
/// One thread at a time.
class RecordedSections {
  public:
    /// Errors: journal_io, journal_corrupt (a sample of a path that was never begun).
    core::Status refresh(const Journal& journal);
    const std::vector<RecordedSection>& all() const { return sections_; }
    std::vector<RecordedSection> take() { return std::move(sections_); }
    /// Of the last sample read; 0: none.
    std::uint64_t last_sequence() const { return last_sequence_; }

  private:
    RecordedSection& section(std::size_t index);

    std::vector<RecordedSection> sections_;
    std::map<std::uint16_t, std::pair<std::size_t, std::uint8_t>> section_of_path_;  // and the pass
    std::uint64_t last_sequence_ = 0;
};

/// Errors: as above.
core::Result<std::vector<RecordedSection>> recorded_sections(const Journal& journal);

}  // namespace cmm::acquisition
