// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/characteristic.hpp"
#include "acquisition/characteristic_spec.hpp"
#include "acquisition/decision_rule.hpp"
#include "acquisition/nominal_measures.hpp"
#include "acquisition/reference_contour.hpp"
#include "acquisition/section_alignment.hpp"
#include "acquisition/section_result.hpp"
#include "acquisition/tolerance_watch.hpp"
#include "core/error.hpp"
#include "fitting/filter.hpp"
#include "fitting/nominal.hpp"
#include "fitting/section.hpp"

namespace cmm::acquisition {

struct EvaluationOptions {
    std::optional<double> profile_mm;       ///< full width of the zone about the sides; absent: reported, not judged
    std::optional<double> edge_profile_mm;  ///< of LE and TE
    fitting::ZoneFilters filters;           ///< of the deviations that the profiles judge; by default none
    std::vector<CharacteristicSpec> asked;  ///< by the part file, beside what is always judged
    /// Of the edges, as the fit was told; a radius of another form is none. Absent: the points chose.
    std::optional<fitting::EdgeModel> le_model, te_model;
    DecisionRule rule;
    AlignmentSpec alignment;
    const NominalMeasures* nominal_measures = nullptr;  ///< for `asked`, where they are made already
    Lean lean = Lean::nominal;                          ///< by which the 2-D offset's error is counted
    std::optional<fitting::PlaneUncertainty> plane;     ///< in which the section was cut; absent: it is known
};

/// A section with its fit and how it lies to its nominal, before its numbers. `section` brings index, name, z and
/// points; the fit's verdicts are copied to the points. `curve`: the nominal as a section, beside `nominal`. `shared`:
/// as of judge_section. Pure; any thread.
SectionResult lay_section(SectionResult section, core::Result<fitting::SectionFit> fit, const ReferenceContour* nominal,
                          const EvaluationOptions& options, const fitting::NominalSection* curve = nullptr,
                          const SectionAlignment* shared = nullptr);

/// Judges a section that lay_section left, with the same arguments. A failed or open fit leaves every characteristic
/// not evaluable. Without a nominal (nullptr) there are no profile characteristics, and those by `options.asked` that
/// need it are not evaluable; places of the nominal that the ball does not reach are left out of them and counted.
/// Uncertainty: that of the fit, and, added as a bound because its sign is known and it is not corrected, the 2-D
/// offset error by the nominal's lean at each surface point. Pure; any thread.
///
/// Alignment of the section: deviations and profiles after its best fit, positions (displacement, centroid, angles
/// from x) in the frame as measured. Of the blade: all of it in the frame that `shared` says; without it, or while that
/// is provisional, what depends on it is decided only where no motion can bring the section in, else left undecided.
/// An alignment that is refused leaves the profiles not evaluable.
SectionResult judge_section(SectionResult section, const ReferenceContour* nominal, const EvaluationOptions& options,
                            const fitting::NominalSection* curve = nullptr, const SectionAlignment* shared = nullptr);

/// Both.
SectionResult evaluate_section(SectionResult section, core::Result<fitting::SectionFit> fit,
                               const ReferenceContour* nominal, const EvaluationOptions& options,
                               const fitting::NominalSection* curve = nullptr,
                               const SectionAlignment* shared = nullptr);

/// Of a section that is not complete: what is out of tolerance all the same. Its uncertainty and guard are those of the
/// watch.
void reject_by(const Exceedance& exceedance, SectionResult& section);

}  // namespace cmm::acquisition
