// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "fitting/section.hpp"
#include "fitting/smoothing.hpp"

namespace cmm::fitting {

/// The curve of ball centres of a section, and what became of its points.
struct CentreCurve {
    std::vector<PointVerdict> verdicts;  ///< one per input point, in input order
    std::size_t rejected = 0;
    std::string missing;  ///< as of SectionFit
    SmoothCurve smooth;   ///< counter-clockwise
    /// The same where edges that are conics tell where they end, for the contour of this section alone: other sections
    /// are told what the points show by themselves, as those that lean have no conics. None: no edge is told.
    std::optional<SmoothCurve> with_edges;
    std::vector<Vec2> good;  ///< the points that it was fitted to, in its order

    const SmoothCurve& of_contour() const { return with_edges ? *with_edges : smooth; }
};

/// The first half of fit_section: order, bad points, smooth curve. Arguments and errors as there.
core::Result<CentreCurve> fit_centre_curve(std::span<const Vec2> centres, std::span<const RejectReason> excluded,
                                           const SectionOptions& options, std::span<const char> kept = {},
                                           std::span<const char> later = {});

}  // namespace cmm::fitting
