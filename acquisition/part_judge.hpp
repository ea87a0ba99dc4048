// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "acquisition/section_result.hpp"
#include "acquisition/section_setup.hpp"
#include "fitting/compensation.hpp"
#include "fitting/contact_points.hpp"
#include "fitting/section_mover.hpp"

namespace cmm::acquisition {

/// The one way from points to a judged part: bad points, fit, compensation, deviations, characteristics, decisions;
/// scan, run file and point file all take it. A section is first judged by itself, compensated in its plane, and
/// provisional; when its neighbours are there, by the surface through all ball centres, or by another method that the
/// part file asks for (docs/compensation.md). Give it the sections in order,
/// as SectionJudge wants them. One owner; deterministic: what `complete` leaves depends on the sections and their order
/// alone, not on calls of `grow`. Where the whole blade is aligned, that is done once when no more sections come, and
/// every section is judged anew by it.
class PartJudge {
  public:
    /// Judges a section by itself, as SectionJudge does. `setup` outlives the judge.
    const SectionResult& finish(const SectionSetup& setup, std::vector<RecordedPoint> points);

    /// The first half of `finish`: the section with its contour, before its numbers.
    SectionResult close(const SectionSetup& setup, std::vector<RecordedPoint> points);
    /// Whether the other half will change the contour: by a method that needs no neighbours.
    static bool changes_when_judged(const SectionResult& closed);
    /// The other half, of a section that judge_laid has judged.
    const SectionResult& take_over(const SectionSetup& setup, SectionResult result);

    /// Lets the surface grow by the newest section, when it lies above the others, and judges anew the one below, which
    /// has neighbours on both sides now. Bounded: the surface is that of the newest sections. Returns what has changed,
    /// valid until the next call.
    std::vector<const SectionResult*> grow();
    /// After that: judges the newest section anew, provisionally, by what is known of its lean: that of the sections
    /// below, of the first two the nominal's. nullptr: nothing is, and it stays as it was.
    const SectionResult* foretell();
    /// No more sections come: all are compensated by the surface through all of them, and aligned. `whole`: they are
    /// all that the part has; otherwise the alignment of the blade stays provisional. Returns as above.
    std::vector<const SectionResult*> complete(bool whole = true);

    /// The same as `complete`, step by step for those who have other work between the steps: lays the surface, then ...
    std::vector<const SectionResult*> begin_completion(bool whole = true);
    /// ... judges one section anew; nullptr: there is none left.
    const SectionResult* complete_next();
    bool completing() const { return (completion_ && !completion_->left.empty()) || !to_align_.empty(); }

    /// What judges the next section by itself.
    const SectionJudge& alone() const { return alone_; }

    /// Whether a section is rejected whatever its neighbours will say. While it is compensated in its plane only, it is
    /// where it would be with walls that lean by `lean_doubt_rad` more than the nominal's; without a nominal nothing is
    /// known of the lean.
    bool rejects_for_certain(std::size_t index) const;

    /// Whether this section has been judged; a second time it takes the place of the first.
    bool has(std::size_t index) const;
    /// As they are now, by index.
    std::vector<SectionResult> results() const;
    /// Hands the sections over, by index.
    std::vector<SectionResult> take();

  private:
    struct Judged {
        const SectionSetup* setup = nullptr;
        SectionResult result;
        bool has_ball = false;                      ///< to be taken off by more than its plane knows
        std::optional<fitting::SectionFit> flat;    ///< as it was compensated in its plane; none: it still is
        std::optional<fitting::SectionFit> alone;   ///< as it was fitted by itself; none: no strays are left out of it
        std::optional<SectionAlignment> alignment;  ///< of the whole blade

        const fitting::SectionFit& in_plane() const { return flat ? *flat : *result.fit; }
        const std::vector<fitting::ContourPoint>& flat_contour() const {
            return alone ? alone->contour : flat->contour;
        }
        /// Before the result gets another fit.
        void keep_flat() {
            if (!flat) flat = std::exchange(result.fit, std::nullopt);
        }
    };
    /// Sections that know of each other, upwards.
    struct Stack {
        fitting::SurfaceCompensation surface;
        std::vector<const Judged*> members = {};
        core::Status add(const Judged& judged);
        /// What their method needs of them all. Errors: those of SurfaceCompensation::fit.
        core::Status fit();
        std::vector<fitting::CentreRow> rows_with(const Judged& judged) const;
    };
    /// All sections are here; those of `left` are not yet compensated by what all of them know.
    struct Completion {
        Stack stack;
        std::vector<Judged*> left;         ///< the lowest last
        std::vector<const Judged*> all{};  ///< that were left at first
    };
    static fitting::CentreRow centre_row(const Judged& judged);
    core::Status lay_stack(const std::vector<Judged*>& upwards, std::vector<const SectionResult*>& revised);
    bool leave_out_strays();
    static bool tells_lean(const Judged& judged);
    void align();
    const SectionResult* align_next();
    void stay_flat(Judged& judged, const core::Error& why);
    void compensate(Judged& judged, const Stack& stack);
    core::Result<fitting::SurfaceSection> compensate_beside_others(const Judged& judged,
                                                                   const fitting::SectionOptions& options) const;
    void compensate_by_points(Judged& judged, const std::vector<fitting::CentreRow>& rows);
    static void take_contour(Judged& judged, fitting::SectionFit fit, Compensation how);

    std::vector<std::unique_ptr<Judged>> sections_;
    SectionJudge alone_;
    std::optional<Stack> growing_;
    Judged* top_ = nullptr;  // of the growing stack
    std::optional<Completion> completion_;
    std::vector<Judged*> to_align_;  ///< the lowest last; judged anew when the blade is aligned
    bool whole_ = true, aligned_ = false;
};

}  // namespace cmm::acquisition
