// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/journal.hpp"
#include "acquisition/nominal.hpp"
#include "acquisition/operator_choice.hpp"
#include "acquisition/part_file.hpp"
#include "acquisition/part_frame.hpp"
#include "acquisition/recorded_sections.hpp"
#include "acquisition/section_result.hpp"
#include "acquisition/section_setup.hpp"
#include "core/error.hpp"

namespace cmm::acquisition {

/// A run as its run file tells it, finished or while another thread or process writes it: what was planned, every point
/// so far, each section judged by the same functions as during the scan. A judgement is kept until its points or the
/// operator's choice change; a section that is still open says nothing about the others. One thread at a time; part
/// frame, mm.
class RunReview {
  public:
    /// Judged by the part file that it was measured with (`part` empty) or by another one. Errors: those of
    /// Journal::read, of the part file and its nominal, and of `refresh`.
    static core::Result<std::unique_ptr<RunReview>> open(const std::string& run_file, const PartFile* part = nullptr);

    const Journal& journal() const { return *journal_; }
    const PartFile& part() const { return part_; }
    bool has_nominal() const { return nominal_ != nullptr; }
    const OperatorChoice& choice() const { return choice_; }
    void choose(OperatorChoice choice);

    /// Reads what was added since. Errors: those of RecordedSections::refresh.
    core::Status refresh() { return recorded_.refresh(*journal_); }
    const RecordedSections& recorded() const { return recorded_; }
    /// Of the section with this index, which need not be recorded. Errors: those of make_section_setup.
    core::Result<const SectionSetup*> setup(std::size_t index);
    /// The section at this place of recorded().all(), judged, as far as its neighbours are there by the surface through
    /// all of them; by itself while a part of it is still to come. Errors: those of make_section_setup.
    core::Result<const SectionResult*> result_at(std::size_t place);
    /// All recorded sections. Errors also: usage (a decision about a point that never came).
    core::Result<PartResult> result();

  private:
    struct Judged {
        std::size_t points = 0;
        SectionResult result;
        SectionJudge judge;       // as it was left
        bool takes_part = false;  // in `compensated_`
    };
    /// Every section of the plan is recorded to its end.
    bool whole() const;
    /// Errors: journal_io, journal_corrupt.
    core::Result<std::optional<PartFrame>> part_frame() const;
    /// What is compensated and aligned with the others.
    enum class Taken { finished, all };
    core::Status judge_all(Taken taken);
    bool takes_part(std::size_t place, Taken taken) const;
    const SectionResult& at(std::size_t place) const;
    RunReview(std::unique_ptr<Journal> journal, PartFile part, std::shared_ptr<const Nominal> nominal);
    double height_mm(std::size_t index) const;

    std::unique_ptr<Journal> journal_;
    PartFile part_;
    std::vector<SourceFile> sources_;
    std::shared_ptr<const Nominal> nominal_;
    OperatorChoice choice_;
    RecordedSections recorded_;
    std::map<std::size_t, SectionSetup> setups_;
    std::vector<Judged> judged_;              // each by itself, in order
    std::vector<SectionResult> compensated_;  // those that take part, as the sections beside them say
    bool compensated_all_ = true;             // and none has come or gone since
    bool compensated_whole_ = false;          // they were all that the plan has
};

}  // namespace cmm::acquisition
