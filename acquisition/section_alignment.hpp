// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "acquisition/alignment.hpp"
#include "acquisition/reference_contour.hpp"
#include "core/error.hpp"
#include "fitting/datum.hpp"
#include "fitting/section.hpp"

namespace cmm::acquisition {

/// An alignment as one of the sections that share it sees it.
struct SectionAlignment {
    Alignment alignment;
    fitting::Datum datum;
};

/// Half widths of the zones to fit into, where the gate gives them (full widths).
struct ProfileWidths {
    std::optional<double> side_mm, edge_mm;
};

/// What the fit is told. Zones without a width take no part where it is into the tolerance.
fitting::BestFitOptions best_fit_options(const AlignmentSpec& spec, const ProfileWidths& widths);

/// A closed section by itself. Errors: those of fit_to_nominal.
core::Result<SectionAlignment> align_section(const fitting::SectionFit& fit, const ReferenceContour& reference,
                                             const fitting::ClosedCurve& nominal, const AlignmentSpec& spec,
                                             const ProfileWidths& widths);

/// A section of several that are aligned as one body; all outlive the call. `use`: by contour point, as of
/// fit_to_nominal.
struct AlignedMember {
    const fitting::SectionFit* fit = nullptr;
    const fitting::ClosedCurve* nominal = nullptr;
    std::vector<char> use;
};
/// One alignment for each, in their order. Errors: those of fit_to_nominals.
core::Result<std::vector<SectionAlignment>> align_blade(std::span<const AlignedMember> members,
                                                        const AlignmentSpec& spec, const ProfileWidths& widths);

/// Which points have a deviation.
std::vector<char> reached(std::span<const std::optional<double>> deviation_mm);

/// The deviations of the contour after the motion is undone. Writes the 2-D offset's errors into the contour, as
/// ReferenceContour::compare does.
std::vector<std::optional<double>> compare_aligned(std::vector<fitting::ContourPoint>& contour,
                                                   const ReferenceContour& reference,
                                                   const fitting::PlaneMotion& motion, Lean lean = Lean::nominal);

}  // namespace cmm::acquisition
