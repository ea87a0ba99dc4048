// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/nominal.hpp"
#include "acquisition/nominal_measures.hpp"
#include "acquisition/part_file.hpp"
#include "acquisition/reference_contour.hpp"
#include "acquisition/section_alignment.hpp"
#include "acquisition/section_result.hpp"
#include "fitting/compensation.hpp"
#include "fitting/error_fields.hpp"
#include "fitting/nominal.hpp"

namespace cmm::acquisition {

/// The nominal of one section, ready for questions: as a closed curve with its edges found, and as what the ball can
/// touch of it. Part frame, mm.
struct SectionNominal {
    fitting::NominalSection section;
    ReferenceContour reference;
    std::shared_ptr<const NominalSurface> surface = {};  ///< where the nominal is one
    double lean_rad = 0.0;                               ///< of its steepest wall
};

/// What must be known to judge a section, whoever brings its points: a scan, a run file or a point file.
struct SectionSetup {
    std::size_t index = 0;
    std::string name;
    double z_mm = 0.0;
    double ball_radius_mm = 1.0;
    std::optional<SectionNominal> nominal;
    std::optional<Eigen::Vector2d> le_hint_mm;  ///< without a nominal: what the part file says
    FittingSpec fitting;
    AlignmentSpec alignment;
    std::optional<SectionAlignment> frame;           ///< by six points (part_frame.hpp)
    std::optional<fitting::PlaneUncertainty> plane;  ///< likewise: of the section's height
    GateSpec gate;
    std::shared_ptr<const NominalMeasures> nominal_measures = {};  ///< for `gate`; absent: each judgement makes its own
    fitting::ErrorFields fields;  ///< of machine, probe and temperature; of nothing where nothing is known
    /// Where the part file asks for it, points are carried to 20 degrees: this many times their distance from the place
    /// that stays. The ball and the height at which the nominal is cut are carried with them.
    double to_20_c = 1.0;
    Eigen::Vector2d fixed_at_mm = Eigen::Vector2d::Zero();

    Eigen::Vector2d at_20_c(const Eigen::Vector2d& measured_mm) const {
        return to_20_c == 1.0 ? measured_mm : Eigen::Vector2d(fixed_at_mm + to_20_c * (measured_mm - fixed_at_mm));
    }
};

/// Cuts the nominal (nullptr: none) at the height and finds its edges. Errors: those of Nominal::cut, input_invalid
/// when the nominal contour has no two edges.
core::Result<SectionSetup> make_section_setup(const PartFile& part, const Nominal* nominal, std::size_t index,
                                              double z_mm);

/// What the fit of a section is told.
fitting::SectionOptions section_options(const SectionSetup& setup);

/// Judges a fit by what the setup says; `section` brings index, name, z and points. `shared`: of the blade's alignment
/// (nullptr: not known yet). `lean`: by which the error of the 2-D offset is counted.
SectionResult judge_fit(SectionResult section, core::Result<fitting::SectionFit> fit, const SectionSetup& setup,
                        const SectionAlignment* shared = nullptr, Lean lean = Lean::nominal);
/// Judges what SectionJudge::close left.
SectionResult judge_laid(SectionResult section, const SectionSetup& setup);

/// The fit of a section without the bad points that the other sections betray, and with the good ones that it had left
/// out beside them (fitting::stray_points); none where there are none. `flat`: as it was fitted by itself.
std::optional<fitting::SectionFit> fit_without_strays(const fitting::SurfaceCompensation& surface,
                                                      const SectionSetup& setup, const SectionResult& section,
                                                      const fitting::SectionFit& flat);

/// Judges single sections of a part, compensated in their planes. Give it a part's sections in order: without a nominal
/// or hint the first section's edge with the larger radius is the LE, and the following sections take the edge next to
/// it, so that near-equal edges do not change their names from section to section. One owner; deterministic.
class SectionJudge {
  public:
    /// Fits a section and lays it onto its nominal; its numbers are not there yet. Verdicts that the points bring along
    /// (no contact, by operator, kept by operator) stand; the others are found anew.
    SectionResult close(const SectionSetup& setup, std::vector<RecordedPoint> points);
    /// The same, and judges it.
    SectionResult finish(const SectionSetup& setup, std::vector<RecordedPoint> points);

  private:
    std::optional<Eigen::Vector2d> last_le_mm_, last_te_mm_;
};

}  // namespace cmm::acquisition
