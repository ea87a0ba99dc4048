// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/nominal.hpp"
#include "acquisition/part_file.hpp"
#include "acquisition/section_result.hpp"
#include "fitting/nominal.hpp"

namespace cmm::acquisition {

/// The nominal of one section, ready for questions: the contour, and the same as a closed curve with its edges found.
/// Part frame, mm.
struct SectionNominal {
    NominalContour contour;
    fitting::NominalSection section;
};

/// What must be known to judge a section, whoever brings its points: a scan, a run file or a point file.
struct SectionSetup {
    std::size_t index = 0;
    std::string name;
    double z_mm = 0.0;
    double ball_radius_mm = 1.0;
    std::optional<SectionNominal> nominal;
    std::optional<Eigen::Vector2d> le_hint_mm;  ///< without a nominal: what the part file says
    GateSpec gate;
};

/// Cuts the nominal (nullptr: none) at the height and finds its edges. Errors: those of Nominal::cut, input_invalid
/// when the nominal contour has no two edges.
core::Result<SectionSetup> make_section_setup(const PartFile& part, const Nominal* nominal, std::size_t index,
                                              double z_mm);

/// The one way from points to a judged section: bad points, fit, deviations, characteristics, decisions. Pure. Verdicts
/// that the points bring along (no contact, by operator) are kept; the others are found anew.
SectionResult finish_section(const SectionSetup& setup, std::vector<RecordedPoint> points);

}  // namespace cmm::acquisition
